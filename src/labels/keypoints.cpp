#include "labels/keypoints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "base/error.h"
#include "labels/objects.h"
#include "labels/projector.h"
#include "labels/sight.h"
#include "render/exposure/camera_motion.h"
#include "render/submit/describe.h"
#include "scene/file_frame.h"
#include "scene/objects.h"

namespace latelight::labels {

namespace {

constexpr double kPointSlack = 1e-5;  // of the distance: vertices and rays are rounded to floats

using Instances = std::vector<uint32_t>;

// Returns the instances whose joints include the node.
Instances instancesOfJoint(const scene::Scene& scene, uint32_t node) {
  Instances instances;
  if (node >= scene.rig.sceneNodes.size()) return instances;
  const uint32_t joint = scene.rig.sceneNodes[node];
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    if (scene.instances[i].removed) continue;
    const scene::Deformation* deformation = scene.meshes[scene.instances[i].mesh].deformation.get();
    if (!deformation || deformation->skin < 0) continue;
    const auto& joints = scene.rig.skins[static_cast<size_t>(deformation->skin)].joints;
    if (std::ranges::find(joints, joint) != joints.end()) instances.push_back(i);
  }
  return instances;
}

// Returns those instances that were not added as copies of a part of the scene.
Instances originalsOf(const scene::Scene& scene, Instances instances) {
  std::erase_if(instances, [&](uint32_t i) { return scene.nodeCopies.contains(scene.instances[i].node); });
  return instances;
}

Instances instancesOfObject(const scene::Scene& scene, uint32_t id) {
  Instances instances;
  for (uint32_t i = 0; i < scene.instances.size(); ++i)
    if (scene.instances[i].id == id && !scene.instances[i].removed) instances.push_back(i);
  return instances;
}

bool isAtOrBelow(const scene::Scene& scene, uint32_t node, uint32_t above) {
  for (int i = static_cast<int>(node); i >= 0; i = scene.nodes[static_cast<size_t>(i)].parent)
    if (static_cast<uint32_t>(i) == above) return true;
  return false;
}

// Returns true if a skin of the copy's meshes moves the node. All other parts of copies stay at rest.
bool isPosedInCopy(const scene::Scene& scene, const Instances& copy, uint32_t node) {
  const Instances skinned = instancesOfJoint(scene, node);
  if (std::ranges::any_of(skinned, [&](uint32_t i) { return std::ranges::find(copy, i) != copy.end(); })) return true;
  const auto isRigid = [&](const scene::Instance& i) { return i.node == node && !i.posed; };
  const int parent = scene.nodes[node].parent;
  return parent >= 0 && std::ranges::none_of(scene.instances, isRigid) &&
         isPosedInCopy(scene, copy, static_cast<uint32_t>(parent));
}

// Returns true for a world with values that are not finite. It has no instances, and default values in their place.
bool isEmptyWorld(const render::WorldStates& worlds, uint32_t world) {
  return !worlds.empty.empty() && worlds.empty[world] != 0;
}

// The transforms of nodes in the world. Edits and worlds place instances, not their nodes, so a node follows the
// instances that it moves with.
class NodeTransforms {
 public:
  // `world`: of `moment`; ignored if it has none.
  NodeTransforms(const scene::Scene& scene, const render::SceneState& moment, uint32_t world)
      : scene_(scene), instancePose_(moment.poses.current), pose_(instancePose_) {
    const render::WorldStates& worlds = moment.worlds;
    const auto isPlaced = [](const scene::Instance& instance) { return instance.placed && !instance.removed; };
    if (worlds.count > 0 && !worlds.transforms.empty())
      toWorld_ = placedInstances(scene, instancePose_, worlds, world).toWorld;
    else if (std::ranges::any_of(scene.instances, isPlaced))
      toWorld_ = scene::instanceTransforms(scene, instancePose_);
    if (!toWorld_.empty()) findCompanions();
    if (worlds.count > 0 && !worlds.deformations.joints.empty() && !isEmptyWorld(worlds, world))
      pose_ = worlds.deformations.poseIn(world, scene, pose_);
  }
  // `skinned`: instances that the node is a joint of. The node follows its own instances, or those that it is a joint
  // of, or those of the nearest ancestor: the ancestor's own, or all below it.
  glm::dmat4 of(uint32_t node, std::span<const uint32_t> skinned) const {
    const glm::dmat4 unplaced = scene::nodeToWorld(scene_, pose_, node);
    if (toWorld_.empty()) return unplaced;
    if (const Companion& own = own_[node]; own.instance) {
      const auto displacement = displacementOf(own);
      return displacement ? *displacement * unplaced : toWorld_[*own.instance];
    }
    if (const auto displacement = scene::commonDisplacement(scene_, instancePose_, toWorld_, skinned))
      return *displacement * unplaced;
    for (int i = static_cast<int>(node); i >= 0; i = scene_.nodes[static_cast<size_t>(i)].parent) {
      const auto at = static_cast<size_t>(i);
      if (const auto displacement = displacementOf(own_[at].instance ? own_[at] : below_[at]))
        return *displacement * unplaced;
    }
    return unplaced;
  }

  // Returns the transform of a node in an added copy of a part of the scene.
  glm::dmat4 inCopy(const scene::NodeCopy& copy, uint32_t node, bool isPosed) const {
    return copy.displacement * scene::nodeToWorld(scene_, isPosed ? pose_ : scene::Pose(), node);
  }

  // Returns the transform of a node that moves with an instance by EXT_mesh_gpu_instancing of the node or of a node
  // above it.
  glm::dmat4 withInstance(uint32_t copy, uint32_t node) const {
    const glm::dmat4 copyToWorld = !toWorld_.empty()       ? toWorld_[copy]
                                   : instancePose_.empty() ? scene_.instances[copy].toWorld
                                                           : scene::followedToWorld(scene_, instancePose_, copy);
    const uint32_t copied = scene_.instances[copy].node;
    if (node == copied) return copyToWorld;
    const glm::dmat4 copiedToWorld = scene::nodeToWorld(scene_, pose_, copied);
    return copyToWorld * glm::inverse(copiedToWorld) * scene::nodeToWorld(scene_, pose_, node);
  }

 private:
  // Stands for several instances, by one of them.
  struct Companion {
    std::optional<uint32_t> instance{};  // empty: there are no instances
    bool movedAlike = true;
  };

  void findCompanions() {
    own_.resize(scene_.nodes.size());
    for (uint32_t i = 0; i < scene_.instances.size(); ++i)
      if (!scene_.instances[i].removed) add(own_[scene_.instances[i].node], {i});
    below_ = own_;
    for (size_t node = below_.size(); node-- > 0;)  // children come after their parents
      if (scene_.nodes[node].parent >= 0) add(below_[static_cast<size_t>(scene_.nodes[node].parent)], below_[node]);
  }
  void add(Companion& all, const Companion& added) const {
    if (!added.instance) return;
    if (!all.instance) {
      all = added;
      return;
    }
    const std::array<uint32_t, 2> both{*all.instance, *added.instance};
    all.movedAlike = all.movedAlike && added.movedAlike &&
                     scene::commonDisplacement(scene_, instancePose_, toWorld_, both).has_value();
  }
  std::optional<glm::dmat4> displacementOf(const Companion& companion) const {
    if (!companion.instance || !companion.movedAlike) return std::nullopt;
    return scene::commonDisplacement(scene_, instancePose_, toWorld_, {&*companion.instance, 1});
  }

  const scene::Scene& scene_;
  scene::Pose instancePose_;         // of the instances
  scene::Pose pose_;                 // with the joints of the world
  std::vector<glm::dmat4> toWorld_;  // by instance; empty: neither an edit nor the world has moved any
  std::vector<Companion> own_;       // the instances of each node; empty as toWorld_
  std::vector<Companion> below_;     // those of the node and all nodes below it
};

bool isInside(glm::dvec2 pixel, const render::Settings& settings) {
  return pixel.x >= 0 && pixel.y >= 0 && pixel.x < settings.width && pixel.y < settings.height;
}

}  // namespace

int findNode(const scene::Scene& scene, const std::string& path) {
  const auto found = std::ranges::find(scene.nodes, path, &scene::Node::path);
  return found == scene.nodes.end() ? -1 : static_cast<int>(found - scene.nodes.begin());
}

std::set<uint32_t> objectsOfNode(const scene::Scene& scene, uint32_t node) {
  std::set<uint32_t> ids{scene.nodes[node].id};
  for (const uint32_t i : instancesOfJoint(scene, node)) ids.insert(scene.instances[i].id);
  return ids;
}

namespace {

// Keypoints of one image, before it is known which are visible.
struct Projections {
  std::vector<ProjectedKeypoint> all;
  std::vector<size_t> inside;  // those within the image

  void add(const ProjectedKeypoint& keypoint, const render::Settings& settings) {
    if (isInside(keypoint.pixel, settings)) inside.push_back(all.size());
    all.push_back(keypoint);
  }
};

// Returns keypoints without a position.
Projections unplaced(size_t count) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  return {std::vector<ProjectedKeypoint>(count,
                                         {.position = glm::dvec3(kNone), .pixel = glm::dvec2(kNone), .depth = kNone}),
          {}};
}

// The image of a camera at an instant.
class KeypointView {
 public:
  KeypointView(const scene::Camera& camera, const scene::Scene& scene, const render::Settings& settings)
      : frameFromWorld_(settings.axes == render::Axes::ZUp ? glm::dmat4(1) : scene::fileFromWorld(scene)),
        described_(render::describeCamera(camera, scene, settings)),
        cameraFromFrame_(glm::inverse(described_.cameraToWorld)) {}

  // `point`: in the world.
  ProjectedKeypoint project(const glm::dvec3& point) const {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    ProjectedKeypoint projected{.position = glm::dvec3(frameFromWorld_ * glm::dvec4(point, 1))};
    const auto at = Projector(described_).project(glm::dvec3(cameraFromFrame_ * glm::dvec4(projected.position, 1)));
    projected.pixel = at ? glm::dvec2(*at) : glm::dvec2(kNone);
    projected.depth = at ? at->z : kNone;
    return projected;
  }

 private:
  glm::dmat4 frameFromWorld_;
  output::CameraMetadata described_;
  glm::dmat4 cameraFromFrame_;
};

// The node, instance or copy that a keypoint follows.
class Anchor {
 public:
  // `object`: Keypoint::object.
  Anchor(const scene::Scene& scene, uint32_t node, uint32_t object) : node_(node) {
    const Instances own = object != 0 ? instancesOfObject(scene, object) : Instances();
    if (!own.empty() && followCopy(scene, own)) {
      ids_ = {object};
      return;
    }
    skinned_ = originalsOf(scene, instancesOfJoint(scene, node));
    ids_ = {scene.nodes[node].id};
    for (const uint32_t i : skinned_) ids_.insert(scene.instances[i].id);
    // Nodes with the meshes of one skin may have been moved differently.
    const auto isOfOthers = [&](uint32_t i) { return std::ranges::find(own, i) == own.end(); };
    if (!std::ranges::all_of(skinned_, isOfOthers)) std::erase_if(skinned_, isOfOthers);
  }

  glm::dmat4 toWorld(const NodeTransforms& nodes) const {
    if (instance_) return nodes.withInstance(*instance_, node_);
    if (copy_) return nodes.inCopy(*copy_, node_, isPosed_);
    return nodes.of(node_, skinned_);
  }
  bool isOf(uint32_t id) const { return ids_.contains(id); }

 private:
  // Returns false if the object is not a copy, or if it does not copy the node.
  bool followCopy(const scene::Scene& scene, const Instances& object) {
    const scene::Instance& first = scene.instances[object.front()];
    if (first.copy >= 0 && first.id != scene.nodes[first.node].id) {
      if (isAtOrBelow(scene, node_, first.node)) instance_ = object.front();
      return instance_.has_value();
    }
    const auto copy = scene.nodeCopies.find(first.node);
    if (copy == scene.nodeCopies.end() || node_ == first.node) return false;
    copy_ = copy->second;
    isPosed_ = isPosedInCopy(scene, object, node_);
    return true;
  }

  uint32_t node_;
  std::optional<uint32_t> instance_;  // by EXT_mesh_gpu_instancing
  std::optional<scene::NodeCopy> copy_;
  bool isPosed_ = false;    // with copy_: the node follows the pose
  Instances skinned_;       // the instances that the node is a joint of
  std::set<uint32_t> ids_;  // the objects that the keypoint belongs to
};

class KeypointProjector {
 public:
  KeypointProjector(const scene::Scene& scene, const render::Settings& settings, std::span<const Keypoint> keypoints)
      : scene_(scene), settings_(settings), keypoints_(keypoints) {
    for (const Keypoint& keypoint : keypoints) {
      const int node = findNode(scene, keypoint.node);
      if (node < 0)
        badUsage("the keypoint \"{}\" follows the node \"{}\", but the scene has no node with this path", keypoint.name,
                 keypoint.node);
      anchors_.emplace_back(scene, static_cast<uint32_t>(node), keypoint.object);
    }
  }

  Projections project(const scene::Camera& camera, const render::SceneState& moment) const {
    const KeypointView view(camera, scene_, settings_);
    const NodeTransforms nodes(scene_, moment, camera.world);
    Projections projected;
    for (size_t i = 0; i < keypoints_.size(); ++i) projected.add(at(i, view, nodes), settings_);
    return projected;
  }

  // Returns the keypoint in a view, without its visibility. `nodes`: at the time of the view.
  ProjectedKeypoint at(size_t i, const KeypointView& view, const NodeTransforms& nodes) const {
    return view.project(glm::dvec3(anchors_[i].toWorld(nodes) * glm::dvec4(keypoints_[i].position, 1)));
  }

  KeypointVisibility visibility(size_t keypoint, const Sight& sight) const {
    if (sight.clipped) return KeypointVisibility::Outside;
    const bool within =
        sight.distance - sight.hit <= keypoints_[keypoint].thickness && anchors_[keypoint].isOf(sight.id);
    return std::isinf(sight.hit) || within ? KeypointVisibility::Visible : KeypointVisibility::Occluded;
  }

 private:
  const scene::Scene& scene_;
  const render::Settings& settings_;
  std::span<const Keypoint> keypoints_;
  std::vector<Anchor> anchors_;  // by keypoint
};

// Keypoints of an image with a rolling shutter: each of them is where its row shows it, at the time of this row.
class RollingKeypoints {
 public:
  RollingKeypoints(const KeypointProjector& projector, const scene::Scene& scene, const scene::Camera& camera,
                   const render::Settings& settings, const render::SceneState& moment)
      : projector_(projector),
        scene_(scene),
        settings_(settings),
        moment_(moment),
        motion_({camera}, moment.previousCameras, moment.nextCameras, moment.motion, settings),
        nodes_(scene, moment, 0) {}

  bool areMoved() const { return settings_.readout != 0 && (motion_.movesCameras() || motion_.movesScene()); }

  // A root of "row of the projection at the time of a row" = "this row", by the secant method.
  ProjectedKeypoint project(size_t i) const {
    constexpr int kMaxSteps = 16;
    constexpr double kPrecision = 1e-6;  // pixels
    const double height = settings_.height;
    double row = height / 2, lastRow = 0, lastError = 0;
    ProjectedKeypoint projected;
    for (int step = 0; step < kMaxSteps; ++step) {
      projected = at(i, row);
      const double error = projected.pixel.y - row;
      if (!(std::abs(error) > kPrecision)) break;  // also if the camera does not project it
      const double slope = step > 0 ? (error - lastError) / (row - lastRow) : -1;
      lastRow = row;
      lastError = error;
      row = std::clamp(slope < 0 ? row - error / slope : row + error, -height, 2 * height);
      if (row == lastRow) break;
    }
    return projected;
  }

  // Returns the lines of sight to the keypoints with these indices, each at the time of its row.
  std::vector<Sight> sights(render::Renderer& renderer, const Projections& projected) const {
    std::map<double, std::vector<size_t>> rows;  // the indices in projected.inside
    for (size_t i = 0; i < projected.inside.size(); ++i)
      rows[std::floor(projected.all[projected.inside[i]].pixel.y) + 0.5].push_back(i);
    std::vector<SightSegment> segments;
    std::vector<size_t> order;
    std::vector<Sight> sights(projected.inside.size());
    const auto cast = [&](const render::SceneState& state) {
      const std::vector<Sight> some = sightsOf(renderer, segments, settings_, state, kPointSlack);
      for (size_t i = 0; i < some.size(); ++i) sights[order[i]] = some[i];
      segments.clear();
      order.clear();
    };
    for (const auto& [row, indices] : rows) {
      const scene::Camera camera = motion_.at(0, secondsOf(row));
      for (const size_t i : indices) {
        const glm::dvec3 point = at(projected.inside[i], row).position;
        segments.push_back(sightSegment(point, camera, scene_, settings_.axes == render::Axes::ZUp));
        order.push_back(i);
      }
      if (motion_.movesScene()) cast(stateAt(row));
    }
    if (!segments.empty()) cast(moment_);
    return sights;
  }

 private:
  // `row`: a vertical pixel coordinate. Rows above and below the image continue the times of its rows.
  double secondsOf(double row) const { return (row / settings_.height - 0.5) * settings_.readout; }

  render::SceneState stateAt(double row) const {
    const scene::Pose pose = motion_.poseAt(secondsOf(row));
    return {.poses = {pose, pose, pose}};
  }

  ProjectedKeypoint at(size_t i, double row) const {
    const KeypointView view(motion_.at(0, secondsOf(row)), scene_, settings_);
    if (!motion_.movesScene()) return projector_.at(i, view, nodes_);
    const render::SceneState state = stateAt(row);
    return projector_.at(i, view, NodeTransforms(scene_, state, 0));
  }

  const KeypointProjector& projector_;
  const scene::Scene& scene_;
  const render::Settings& settings_;
  const render::SceneState& moment_;
  render::CameraMotion motion_;
  NodeTransforms nodes_;  // at the image's time
};

}  // namespace

std::vector<ProjectedKeypoint> projectKeypoints(render::Renderer& renderer, const scene::Scene& scene,
                                                const scene::Camera& camera, const render::Settings& settings,
                                                const render::SceneState& moment, std::span<const Keypoint> keypoints) {
  const KeypointProjector projector(scene, settings, keypoints);
  const RollingKeypoints rolling(projector, scene, camera, settings, moment);
  Projections projected;
  if (rolling.areMoved())
    for (size_t i = 0; i < keypoints.size(); ++i) projected.add(rolling.project(i), settings);
  else
    projected = projector.project(camera, moment);
  if (projected.inside.empty()) return projected.all;
  std::vector<glm::dvec3> points;
  for (const size_t i : projected.inside) points.push_back(projected.all[i].position);
  const std::vector<Sight> sights = rolling.areMoved()
                                        ? rolling.sights(renderer, projected)
                                        : sightsOf(renderer, scene, camera, settings, moment, points, kPointSlack);
  for (size_t i = 0; i < points.size(); ++i)
    projected.all[projected.inside[i]].visibility = projector.visibility(projected.inside[i], sights[i]);
  return projected.all;
}

std::vector<std::vector<ProjectedKeypoint>> projectKeypointsOfWorlds(
    render::Renderer& renderer, const scene::Scene& scene, std::span<const scene::Camera> cameras,
    const render::Settings& settings, const render::SceneState& moment, std::span<const Keypoint> keypoints) {
  const KeypointProjector projector(scene, settings, keypoints);
  std::vector<Projections> projected;
  std::vector<SightLine> lines;
  for (const scene::Camera& camera : cameras) {
    const Projections& each = projected.emplace_back(
        isEmptyWorld(moment.worlds, camera.world) ? unplaced(keypoints.size()) : projector.project(camera, moment));
    for (const size_t i : each.inside) lines.push_back({&camera, each.all[i].position});
  }
  const std::vector<Sight> sights = sightsOfWorlds(renderer, scene, lines, settings, moment, kPointSlack);
  auto sight = sights.begin();
  std::vector<std::vector<ProjectedKeypoint>> all;
  for (Projections& each : projected) {
    for (const size_t i : each.inside) each.all[i].visibility = projector.visibility(i, *sight++);
    all.push_back(std::move(each.all));
  }
  return all;
}

}  // namespace latelight::labels
