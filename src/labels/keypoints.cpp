#include "labels/keypoints.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

#include "base/error.h"
#include "labels/projector.h"
#include "labels/sight.h"
#include "render/submit/describe.h"
#include "scene/file_frame.h"
#include "scene/objects.h"

namespace latelight::labels {

namespace {

constexpr double kPointSlack = 1e-5;  // of the distance: vertices and rays are rounded to floats

// A node's transform in the world. An edit places instances, not their nodes, so the node follows its instance then.
class NodeTransforms {
 public:
  NodeTransforms(const scene::Scene& scene, const scene::Pose& pose) : scene_(scene), pose_(pose) {
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
      if (const scene::Instance& instance = scene.instances[i]; !instance.removed && instance.placed)
        placed_.emplace(instance.node, i);
  }
  glm::dmat4 of(uint32_t node) const {
    if (const auto instance = placed_.find(node); instance != placed_.end())
      return scene_.instances[instance->second].toWorld;
    return scene::nodeToWorld(scene_, pose_, node);
  }

 private:
  const scene::Scene& scene_;
  const scene::Pose& pose_;
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

std::vector<ProjectedKeypoint> projectKeypoints(render::Renderer& renderer, const scene::Scene& scene,
                                                const scene::Camera& camera, const render::Settings& settings,
                                                const render::SceneState& moment, std::span<const Keypoint> keypoints) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const bool zUp = settings.axes == render::Axes::ZUp;
  const glm::dmat4 frameFromWorld = zUp ? glm::dmat4(1) : scene::fileFromWorld(scene);
  const output::CameraMetadata described = render::describeCamera(camera, scene, settings);
  const Projector projector(described);
  const glm::dmat4 cameraFromFrame = glm::inverse(described.cameraToWorld);
  const NodeTransforms nodes(scene, moment.poses.current);
  std::vector<ProjectedKeypoint> projected;
  std::vector<size_t> inside;  // keypoints in the image
  std::vector<glm::dvec3> points;
  for (const Keypoint& keypoint : keypoints) {
    const int node = findNode(scene, keypoint.node);
    if (node < 0)
      badUsage("the keypoint \"{}\" follows the node \"{}\", but the scene has no node with this path", keypoint.name,
               keypoint.node);
    ProjectedKeypoint& p = projected.emplace_back();
    p.position = glm::dvec3(frameFromWorld * nodes.of(static_cast<uint32_t>(node)) * glm::dvec4(keypoint.position, 1));
    const auto at = projector.project(glm::dvec3(cameraFromFrame * glm::dvec4(p.position, 1)));
    p.pixel = at ? glm::dvec2(*at) : glm::dvec2(kNone);
    p.depth = at ? at->z : kNone;
    if (!at || !isInside(p.pixel, settings)) continue;
    inside.push_back(projected.size() - 1);
    points.push_back(p.position);
  }
  if (inside.empty()) return projected;
  const std::vector<Sight> sights = sightsOf(renderer, scene, camera, settings, moment, points, kPointSlack);
  for (size_t i = 0; i < inside.size(); ++i) {
    const Keypoint& keypoint = keypoints[inside[i]];
    const bool within =
        sights[i].distance - sights[i].hit <= keypoint.thickness &&
        objectsOfNode(scene, static_cast<uint32_t>(findNode(scene, keypoint.node))).contains(sights[i].id);
    projected[inside[i]].visibility =
        std::isinf(sights[i].hit) || within ? KeypointVisibility::Visible : KeypointVisibility::Occluded;
  }
  return projected;
}

}  // namespace latelight::labels
