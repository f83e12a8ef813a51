// Adds skins, and poses the meshes that they deform at rest; see scene/rig_edit.h.
#include <cmath>
#include <glm/gtc/matrix_access.hpp>
#include <utility>

#include "base/error.h"
#include "base/reserve.h"
#include "scene/origin.h"
#include "scene/rig_edit.h"
#include "scene/rig_edit_steps.h"

namespace latelight::scene {

uint32_t addSkin(Scene& scene, std::span<const uint32_t> joints, std::vector<mat4> inverseBind) {
  if (joints.empty()) badUsage("a skin must have a joint");
  if (inverseBind.size() != joints.size())
    badUsage("a skin has {} joints but {} inverse bind matrices: the numbers must match", joints.size(),
             inverseBind.size());
  for (const mat4& m : inverseBind) {
    for (int i = 0; i < 16; ++i)
      if (!std::isfinite(m[i / 4][i % 4])) badUsage("an inverse bind matrix of a skin has a number that is not finite");
    if (glm::row(m, 3) != vec4(0, 0, 0, 1)) badUsage("an inverse bind matrix must have the last row 0 0 0 1");
  }
  coverNodes(scene);
  reserveMore(scene.rig.skins, 1);
  Skin skin{.inverseBind = std::move(inverseBind)};
  dvec3 mean(0);
  for (const uint32_t joint : joints) {
    skin.joints.push_back(scene.rig.sceneNodes.at(joint));
    scene.nodes[joint].followed = true;
    mean += dvec3((toGltfFromWorld() * scene.nodes[joint].toWorld)[3]) / double(joints.size());
  }
  skin.origin = originNear(mean);
  scene.rig.skins.push_back(std::move(skin));
  return static_cast<uint32_t>(scene.rig.skins.size() - 1);
}

void poseAtRest(const Scene& scene, Mesh& mesh) {
  const Deformation& d = *mesh.deformation;
  const Pose rest = restPose(scene);
  std::vector<mat4> joints;
  if (d.skin >= 0) joints = jointMatrices(scene.rig.skins[static_cast<size_t>(d.skin)], rest);
  std::vector<float> weights;
  if (d.weightsNode >= 0) weights = rest.weights[static_cast<size_t>(d.weightsNode)];
  DeformedVertices posed = deform(d, joints, weights);
  mesh.positions = std::move(posed.positions);
  mesh.attributes = std::move(posed.attributes);
}

std::shared_ptr<const Deformation> weightedBy(uint32_t rigNode, const Deformation& deformation) {
  auto weighted = std::make_shared<Deformation>(deformation);
  weighted->weightsNode = static_cast<int>(rigNode);
  return weighted;
}

void poseByJoints(const Scene& scene, const Pose& rest, Mesh& mesh) {
  const auto joints = jointMatrices(scene.rig.skins[static_cast<size_t>(mesh.deformation->skin)], rest);
  if (isMirrored(reachOf(*mesh.deformation), joints) != mesh.deformation->mirroredAtRest) {
    auto turned = std::make_shared<Deformation>(*mesh.deformation);
    turned->mirroredAtRest = !turned->mirroredAtRest;
    mesh.deformation = std::move(turned);
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  }
  poseAtRest(scene, mesh);
  findBounds(mesh);
}

}  // namespace latelight::scene
