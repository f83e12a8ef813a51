// Writes cameras.
#include <cmath>
#include <utility>

#include "base/log.h"
#include "export/document_nodes.h"

namespace latelight::exports {

using namespace scene;

namespace {

Json describeCamera(const Camera& camera) {
  Json projection{{"znear", shortest(camera.nearClip)}};
  if (std::isfinite(camera.farClip)) projection["zfar"] = shortest(camera.farClip);
  if (camera.orthographic) {
    constexpr double kFar = 1e6;  // meters, for a camera that sees to infinity, which glTF does not define
    if (!std::isfinite(camera.farClip)) projection["zfar"] = kFar;
    projection["xmag"] = shortest(camera.yHalf * camera.aspect.value_or(1));
    projection["ymag"] = shortest(camera.yHalf);
  } else {
    projection["yfov"] = shortest(camera.verticalFov);
    if (camera.aspect) projection["aspectRatio"] = shortest(*camera.aspect);
  }
  const char* type = camera.orthographic ? "orthographic" : "perspective";
  Json out{{"type", type}, {type, std::move(projection)}};
  if (!camera.name.empty()) out["name"] = camera.name;
  return out;
}

int nodeOfCamera(DocumentNodes& nodes, const Camera& camera) {
  const int own = camera.node >= 0 ? nodes.ofScene[size_t(camera.node)] : -1;
  if (own >= 0 && !nodes.at(own).contains("camera")) {
    Camera placed = camera;
    placeCamera(placed, nodes.placeInFile(camera.node));
    if (placed.toWorld == camera.toWorld) return own;
  }
  Json node{{"name", camera.name.empty() ? "camera" : camera.name}};
  setMatrix(node, toGltfFromWorld() * camera.toWorld * toWorldFromGltf());
  return nodes.add(std::move(node), -1);
}

}  // namespace

void addCameras(const Scene& scene, DocumentNodes& nodes, std::vector<int>& indices) {
  indices.assign(scene.cameras.size(), -1);
  for (size_t i = 0; i < scene.cameras.size(); ++i) {
    const Camera& camera = scene.cameras[i];
    if (camera.lens || camera.principal != vec2(0)) {
      warn("the camera {} has a lens or a shifted center, which glTF does not define, and is left out", camera.name);
      continue;
    }
    indices[i] = static_cast<int>(nodes.document.add("cameras", describeCamera(camera)));
    nodes.at(nodeOfCamera(nodes, camera))["camera"] = indices[i];
  }
}

}  // namespace latelight::exports
