#include "data/cameras/target.h"

#include "base/error.h"
#include "scene/exact_math.h"
#include "scene/file_frame.h"

namespace latelight::data {

using glm::dvec3;

std::vector<bool> nodesBelow(const scene::Scene& scene, const std::string& node, const std::string& path) {
  std::vector<bool> below(scene.nodes.size());
  bool known = false;
  for (size_t i = 0; i < scene.nodes.size(); ++i) {  // parents first
    const scene::Node& each = scene.nodes[i];
    const bool isNamed = each.path == node || each.name == node;
    known |= isNamed;
    below[i] = isNamed || (each.parent >= 0 && below[static_cast<size_t>(each.parent)]);
  }
  if (!known) badUsage("{}: {} has no node \"{}\"", path, scene.source, node);
  return below;
}

std::vector<uint32_t> instancesBelow(const scene::Scene& scene, const std::string& node, const std::string& path) {
  const std::vector<bool> below = nodesBelow(scene, node, path);
  std::vector<uint32_t> instances;
  for (uint32_t i = 0; i < scene.instances.size(); ++i)
    if (isShown(scene, {}, scene.instances[i]) && below[scene.instances[i].node]) instances.push_back(i);
  return instances;
}

Aabb boxOf(const scene::Scene& scene, const std::vector<uint32_t>& instances, const std::string& path) {
  Aabb box;
  const glm::dmat4 toFile = scene::fileFromWorld(scene);
  for (const uint32_t number : instances) {
    const scene::Mesh& mesh = scene.meshes[scene.instances[number].mesh];
    if (mesh.positions.empty()) continue;
    const glm::dmat4 transform = toFile * scene.instances[number].toWorld;
    for (int corner = 0; corner < 8; ++corner) {
      const dvec3 p(corner & 1 ? mesh.boundsMax.x : mesh.boundsMin.x, corner & 2 ? mesh.boundsMax.y : mesh.boundsMin.y,
                    corner & 4 ? mesh.boundsMax.z : mesh.boundsMin.z);
      box.add(dvec3(transform * glm::dvec4(p, 1)));
    }
  }
  if (!(box.low.x <= box.high.x)) badUsage("{}: there is nothing to be seen in {}", path, scene.source);
  return box;
}

Aabb boxOfScene(const scene::Scene& scene, const std::string& path) {
  std::vector<uint32_t> all;
  for (uint32_t i = 0; i < scene.instances.size(); ++i)
    if (isShown(scene, {}, scene.instances[i])) all.push_back(i);
  return boxOf(scene, all, path);
}

Target readTarget(Spec& spec, const CameraContext& context) {
  const std::string path = spec.pathOf("target");
  if (spec.has("target") && spec.at("target").is_array()) return {spec.vector("target"), 0};
  Aabb box;
  if (spec.has("target") && spec.at("target").is_object()) {
    Spec node = spec.object("target");
    box = boxOf(context.scene, instancesBelow(context.scene, node.text("node"), node.pathOf("node")), path);
    node.finish();
  } else {
    if (spec.has("target") && spec.at("target") != "scene")
      badUsage("{} must be \"scene\", a point [x, y, z] or {{\"node\": ...}}, not {}", path, shown(spec.at("target")));
    box = boxOfScene(context.scene, path);
  }
  return {box.center(), box.radius()};
}

Interval readDistance(Spec& spec, std::string_view key, const Target& target, double halfAngle) {
  if (spec.has(key)) return spec.interval(key, kPositive);
  if (target.radius == 0 || halfAngle == 0)
    badUsage("{} requires \"{}\", because a point or a panoramic image has no fitting distance", spec.path(), key);
  constexpr double kMargin = 1.04;
  const double fitting = kMargin * target.radius / exact::sine(halfAngle);
  return {fitting, fitting};
}

}  // namespace latelight::data
