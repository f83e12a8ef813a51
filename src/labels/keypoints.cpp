#include "labels/keypoints.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

#include "base/error.h"
#include "labels/objects.h"
#include "labels/projector.h"
#include "labels/sight.h"
#include "render/submit/describe.h"
#include "scene/file_frame.h"
#include "scene/objects.h"

namespace latelight::labels {

namespace {

constexpr double kPointSlack = 1e-5;  // of the distance: vertices and rays are rounded to floats

// A node's transform in the world. Edits and worlds place instances, not their nodes, so the node follows its instance
// then.
class NodeTransforms {
 public:
  // `world`: of `moment`; ignored if it has none.
  NodeTransforms(const scene::Scene& scene, const render::SceneState& moment, uint32_t world)
      : scene_(scene), pose_(moment.poses.current) {
    std::vector<uint8_t> placed(scene.instances.size(), 0);
    for (size_t i = 0; i < placed.size(); ++i) placed[i] = scene.instances[i].placed;
    const render::WorldStates& worlds = moment.worlds;
    if (worlds.count > 0) {
      toWorld_ = placedInstances(scene, pose_, worlds, world).toWorld;
      for (const uint32_t i : worlds.instances)
        if (!worlds.transforms.empty()) placed[i] = 1;
      const bool isEmpty = !worlds.empty.empty() && worlds.empty[world] != 0;
      if (!worlds.deformations.joints.empty() && !isEmpty) pose_ = worlds.deformations.poseIn(world, scene, pose_);
    }
    for (uint32_t i = 0; i < placed.size(); ++i)
      if (placed[i] && !scene.instances[i].removed) placed_.emplace(scene.instances[i].node, i);
  }
  glm::dmat4 of(uint32_t node) const {
    const auto instance = placed_.find(node);
    if (instance == placed_.end()) return scene::nodeToWorld(scene_, pose_, node);
    return toWorld_.empty() ? scene_.instances[instance->second].toWorld : toWorld_[instance->second];
  }

 private:
  const scene::Scene& scene_;
  scene::Pose pose_;                               // with the joints of the world
  std::vector<glm::dmat4> toWorld_;                // in a world, by instance; empty: the scene's
  std::unordered_map<uint32_t, uint32_t> placed_;  // instances by node
};

// Returns the ids of the objects that a node belongs to: its own, and those of the skins that it is a joint of.
std::set<uint32_t> objectsOfNode(const scene::Scene& scene, uint32_t node) {
  std::set<uint32_t> ids{scene.nodes[node].id};
  if (node >= scene.rig.sceneNodes.size()) return ids;
  const uint32_t joint = scene.rig.sceneNodes[node];
  for (const scene::Instance& instance : scene.instances) {
    if (instance.removed) continue;
    const scene::Deformation* deformation = scene.meshes[instance.mesh].deformation.get();
    if (!deformation || deformation->skin < 0) continue;
    const auto& joints = scene.rig.skins[static_cast<size_t>(deformation->skin)].joints;
    if (std::ranges::find(joints, joint) != joints.end()) ids.insert(instance.id);
  }
  return ids;
}

bool isInside(glm::dvec2 pixel, const render::Settings& settings) {
  return pixel.x >= 0 && pixel.y >= 0 && pixel.x < settings.width && pixel.y < settings.height;
}

}  // namespace

int findNode(const scene::Scene& scene, const std::string& path) {
  const auto found = std::ranges::find(scene.nodes, path, &scene::Node::path);
  return found == scene.nodes.end() ? -1 : static_cast<int>(found - scene.nodes.begin());
}

namespace {

// Keypoints of one image, before it is known which are visible.
struct Projections {
  std::vector<ProjectedKeypoint> all;
  std::vector<size_t> inside;  // those within the image
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
      nodes_.push_back(static_cast<uint32_t>(node));
      ids_.push_back(objectsOfNode(scene, nodes_.back()));
    }
  }

  Projections project(const scene::Camera& camera, const render::SceneState& moment) const {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const bool zUp = settings_.axes == render::Axes::ZUp;
    const glm::dmat4 frameFromWorld = zUp ? glm::dmat4(1) : scene::fileFromWorld(scene_);
    const output::CameraMetadata described = render::describeCamera(camera, scene_, settings_);
    const Projector projector(described);
    const glm::dmat4 cameraFromFrame = glm::inverse(described.cameraToWorld);
    const NodeTransforms nodes(scene_, moment, camera.world);
    Projections projected;
    for (size_t i = 0; i < keypoints_.size(); ++i) {
      ProjectedKeypoint& p = projected.all.emplace_back();
      p.position = glm::dvec3(frameFromWorld * nodes.of(nodes_[i]) * glm::dvec4(keypoints_[i].position, 1));
      const auto at = projector.project(glm::dvec3(cameraFromFrame * glm::dvec4(p.position, 1)));
      p.pixel = at ? glm::dvec2(*at) : glm::dvec2(kNone);
      p.depth = at ? at->z : kNone;
      if (at && isInside(p.pixel, settings_)) projected.inside.push_back(i);
    }
    return projected;
  }

  KeypointVisibility visibility(size_t keypoint, const Sight& sight) const {
    const bool within =
        sight.distance - sight.hit <= keypoints_[keypoint].thickness && ids_[keypoint].contains(sight.id);
    return std::isinf(sight.hit) || within ? KeypointVisibility::Visible : KeypointVisibility::Occluded;
  }

 private:
  const scene::Scene& scene_;
  const render::Settings& settings_;
  std::span<const Keypoint> keypoints_;
  std::vector<uint32_t> nodes_;
  std::vector<std::set<uint32_t>> ids_;  // objects of each keypoint's node
};

}  // namespace

std::vector<ProjectedKeypoint> projectKeypoints(render::Renderer& renderer, const scene::Scene& scene,
                                                const scene::Camera& camera, const render::Settings& settings,
                                                const render::SceneState& moment, std::span<const Keypoint> keypoints) {
  const KeypointProjector projector(scene, settings, keypoints);
  Projections projected = projector.project(camera, moment);
  if (projected.inside.empty()) return projected.all;
  std::vector<glm::dvec3> points;
  for (const size_t i : projected.inside) points.push_back(projected.all[i].position);
  const std::vector<Sight> sights = sightsOf(renderer, scene, camera, settings, moment, points, kPointSlack);
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
    const Projections& each = projected.emplace_back(projector.project(camera, moment));
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
