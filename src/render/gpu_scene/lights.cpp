#include "render/gpu_scene/lights.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/log.h"
#include "render/gpu_scene/light_tree.h"
#include "render/gpu_scene/ltc_table.h"
#include "shared/color.h"
#include "shared/light.h"

namespace latelight::render {

namespace {

bool isFinite(const shared::AreaLight& l) {
  for (const glm::vec3& v : {l.center, l.x, l.y, l.z, l.radiance})
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) return false;
  return true;
}

bool isFinite(const shared::Light& l) {
  for (const glm::vec3& v : {l.position, l.direction, l.intensity})
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) return false;
  return !std::isnan(l.radius) && std::isfinite(l.spotScale) && std::isfinite(l.spotOffset);
}

// Uploads the elements that differ from `before`.
template <typename T>
void uploadChanges(GpuList<T>& list, vk::Uploader& uploader, const std::vector<T>& before, const std::vector<T>& now) {
  std::vector<uint32_t> changed;
  for (size_t i = 0; i < now.size(); ++i)
    if (i >= before.size() || std::memcmp(&before[i], &now[i], sizeof(T)) != 0)
      changed.push_back(static_cast<uint32_t>(i));
  if (list.address() == 0)
    list.upload(uploader, now);
  else
    list.upload(uploader, now, changed);
}

}  // namespace

// A light without a range is unbounded: even far away it contributes to highlights on glossy surfaces and to the sum of
// many lights. Any radius that bounds the error of these would be larger than the scene.
shared::Light deviceLight(const scene::Light& light, const glm::dvec3& origin) {
  shared::Light l{};
  l.position = glm::vec3(light.position - origin);
  l.direction = light.direction;
  l.type = light.type;
  l.intensity = light.color * light.intensity;
  l.radius = std::numeric_limits<float>::infinity();
  if (!shared::lightIsDirectional(light.type)) l.radius = light.range.value_or(l.radius);
  l.inverseRadius2 = shared::inverseRadius2(l.radius);
  if (shared::lightHasCone(light.type)) shared::spotCone(light.innerCone, light.outerCone, l.spotScale, l.spotOffset);
  l.size = shared::lightIsDirectional(light.type) ? std::tan(light.size / 2) : light.size;
  return l;
}

// A shape without extent emits nothing. Its radiance is then 0.
shared::AreaLight deviceAreaLight(const scene::Light& light, const glm::dvec3& origin) {
  shared::AreaLight l{};
  const bool flat = light.type == shared::kLightRect || light.type == shared::kLightDisk;
  const glm::mat3& axes = light.axes;
  glm::vec3 half(light.size);
  if (light.type == shared::kLightRect) half = {light.width / 2, light.height / 2, 1};
  if (light.type == shared::kLightTube) half.x = light.length / 2;
  l.center = glm::vec3(light.position - origin);
  l.type = light.type;
  l.x = axes[0] * half.x;
  l.y = axes[1] * half.y;
  l.z = axes[2] * half.z;
  l.twoSided = light.twoSided ? 1 : 0;
  const glm::dvec3 normal = glm::cross(glm::dvec3(l.x), glm::dvec3(l.y));
  const double area = glm::length(normal), volume = std::abs(glm::dot(normal, glm::dvec3(l.z)));
  // Mirrored or not, -Z is on the emitting side.
  if (flat && area > 0) l.z = glm::vec3(normal / area * (glm::dot(normal, glm::dvec3(axes[2])) < 0 ? 1.0 : -1.0));
  const float lengths = glm::length(l.x) * glm::length(l.y);
  l.orthogonal = std::abs(glm::dot(l.x, l.y)) < 1e-5f * lengths ? 1 : 0;
  constexpr double kLeast = 1e-30;  // products of lengths stay within the range of floats
  if ((flat ? area : volume) > kLeast) l.radiance = light.color * light.intensity;
  return l;
}

LightSet makeLightSet(std::vector<scene::Light> lights, const glm::dvec3& origin) {
  LightSet set{.authored = std::move(lights)};
  std::erase_if(set.authored, [](const scene::Light& light) { return light.removed; });
  std::vector<shared::Light> shining;
  std::vector<uint32_t> sources;
  size_t broken = 0;
  for (uint32_t i = 0; i < set.authored.size(); ++i) {
    if (shared::lightIsArea(set.authored[i].type)) {
      const shared::AreaLight l = deviceAreaLight(set.authored[i], origin);
      broken += !isFinite(l);
      if (!isFinite(l) || !(shared::maxChannel(l.radiance) > 0)) continue;
      set.area.push_back(l);
      set.areaSources.push_back(i);
      continue;
    }
    const shared::Light l = deviceLight(set.authored[i], origin);
    broken += !isFinite(l);
    if (!isFinite(l) || !(l.radius > 0) || !(shared::maxChannel(l.intensity) > 0)) continue;
    shining.push_back(l);
    sources.push_back(i);
  }
  if (broken)
    warn("{} of {} lights are skipped, because they have a value that is not finite", broken, set.authored.size());
  LightTree tree = buildLightTree(shining);
  for (const uint32_t source : tree.sources) set.sources.push_back(sources[source]);
  set.directional = tree.directionalLights;
  set.unbounded = static_cast<uint32_t>(
                      std::ranges::count(tree.lights, std::numeric_limits<float>::infinity(), &shared::Light::radius)) -
                  set.directional;
  set.leaves = tree.firstLeaf;
  set.lights = std::move(tree.lights);
  set.nodes = std::move(tree.nodes);
  return set;
}

void LightSet::describe(shared::FrameConstants& frame) const {
  frame.lightCount = static_cast<uint32_t>(lights.size());
  frame.directionalLights = directional;
  frame.lightTreeLeaves = leaves;
  frame.areaLightCount = static_cast<uint32_t>(area.size());
}

void GpuLights::set(vk::Uploader& uploader, std::vector<scene::Light> lights, const glm::dvec3& origin) {
  LightSet now = makeLightSet(std::move(lights), origin);
  uploadChanges(list_, uploader, set_.lights, now.lights);
  uploadChanges(tree_, uploader, set_.nodes, now.nodes);
  if (!now.area.empty()) {
    uploadChanges(area_, uploader, set_.area, now.area);
    storeLtcTable(uploader);
  }
  set_ = std::move(now);
}

void GpuLights::storeLtcTable(vk::Uploader& uploader) {
  if (ltcTable_.address() == 0) ltcTable_.upload(uploader, ltcTable());
}

void GpuLights::describe(shared::FrameConstants& frame) const {
  frame.lights = list_.address();
  frame.lightTree = tree_.address();
  frame.areaLights = area_.address();
  frame.ltcTable = ltcTable_.address();
  set_.describe(frame);
}

}  // namespace latelight::render
