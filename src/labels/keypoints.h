// Keypoints: named points that follow nodes of the scene, projected to a camera's image, with their visibility as COCO
// defines it (Lin et al. 2014, "Microsoft COCO: Common Objects in Context").
#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "render/submit/renderer.h"

namespace latelight::labels {

struct Keypoint {
  std::string name;
  std::string node;        // path of the node that it follows, which may be a joint of a skin
  glm::dvec3 position{0};  // in the node's frame, before the node's scale
  // Meters that the keypoint's own object may be in front of it, as flesh is in front of a joint.
  double thickness = 0;
  // The id of the object that the keypoint moves with, which may be a copy of the node, of a node above it or of a mesh
  // that the node is a joint of; 0: it moves with the node itself.
  uint32_t object = 0;
};

enum class KeypointVisibility : uint8_t {
  Outside = 0,   // not in the image, or not between the camera's near and far planes
  Occluded = 1,  // in the image, behind a surface
  Visible = 2,
};

// With a rolling shutter, all values are those of the time at which the keypoint's row is exposed.
struct ProjectedKeypoint {
  glm::dvec3 position{0};  // in the frame of the settings' axes, meters; NaN in a world with values that are not finite
  glm::dvec2 pixel{0};     // NaN if the camera does not project it; it may lie outside the image
  double depth = 0;        // as the output `depth`; NaN if the camera does not project it
  KeypointVisibility visibility = KeypointVisibility::Outside;
};

// Returns one per keypoint. Throws Error(Usage) if the scene has no such node.
std::vector<ProjectedKeypoint> projectKeypoints(render::Renderer& renderer, const scene::Scene& scene,
                                                const scene::Camera& camera, const render::Settings& settings,
                                                const render::SceneState& moment, std::span<const Keypoint> keypoints);

// The same for cameras that show the worlds of `moment`, which has lists and not arrays for shaders. Returns one list
// per camera. In a world with values that are not finite, all numbers are NaN, and the visibility is Outside.
std::vector<std::vector<ProjectedKeypoint>> projectKeypointsOfWorlds(
    render::Renderer& renderer, const scene::Scene& scene, std::span<const scene::Camera> cameras,
    const render::Settings& settings, const render::SceneState& moment, std::span<const Keypoint> keypoints);

// Returns the index of the node with this path, or -1.
int findNode(const scene::Scene& scene, const std::string& path);

// Returns the ids of the objects that a node belongs to: its own, and those of the skins that it is a joint of.
std::set<uint32_t> objectsOfNode(const scene::Scene& scene, uint32_t node);

}  // namespace latelight::labels
