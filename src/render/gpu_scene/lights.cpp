#include "render/gpu_scene/lights.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/log.h"
#include "render/gpu_scene/light_tree.h"
#include "shared/color.h"
#include "shared/light.h"

namespace latelight::render {

namespace {

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
  return l;
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

LightSet makeLightSet(std::vector<scene::Light> lights, const glm::dvec3& origin) {
  LightSet set{.authored = std::move(lights)};
  std::erase_if(set.authored, [](const scene::Light& light) { return light.removed; });
  std::vector<shared::Light> shining;
  std::vector<uint32_t> sources;
  size_t broken = 0;
  for (uint32_t i = 0; i < set.authored.size(); ++i) {
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
}

void GpuLights::set(vk::Uploader& uploader, std::vector<scene::Light> lights, const glm::dvec3& origin) {
  LightSet now = makeLightSet(std::move(lights), origin);
  uploadChanges(list_, uploader, set_.lights, now.lights);
  uploadChanges(tree_, uploader, set_.nodes, now.nodes);
  set_ = std::move(now);
}

void GpuLights::describe(shared::FrameConstants& frame) const {
  frame.lights = list_.address();
  frame.lightTree = tree_.address();
  set_.describe(frame);
}

}  // namespace latelight::render
