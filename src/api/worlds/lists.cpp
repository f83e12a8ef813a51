// Lists in place of arrays: the host reads the numbers of worlds that shaders do not place.
#include <algorithm>
#include <cmath>
#include <limits>

#include "api/worlds/converter.h"
#include "api/worlds/messages.h"
#include "api/worlds/world_array.h"

namespace latelight {

namespace {

constexpr WorldArray WorldArrays::*kOfPlacement[] = {
    &WorldArrays::transforms,
    &WorldArrays::previousTransforms,
    &WorldArrays::nextTransforms,
    &WorldArrays::exists,
    &WorldArrays::cameraToWorld,
    &WorldArrays::previousCameraToWorld,
    &WorldArrays::nextCameraToWorld,
    &WorldArrays::intrinsics,
    &WorldArrays::baseColor,
    &WorldArrays::metallic,
    &WorldArrays::roughness,
    &WorldArrays::emissive,
    &WorldArrays::materialChoice,
    &WorldArrays::lightPosition,
    &WorldArrays::lightDirection,
    &WorldArrays::lightColor,
    &WorldArrays::lightIntensity,
    &WorldArrays::environmentRotation,
    &WorldArrays::environmentIntensity,
    &WorldArrays::environmentIndex,
};
constexpr size_t kOfDeformation = 6;
static_assert(sizeof(WorldArrays) ==
              (std::size(kOfPlacement) + kOfDeformation) * sizeof(WorldArray) + sizeof(uint64_t));

// A camera matrix with a value that is not finite becomes NaNs, which findInvalid() finds. `cameras`: per world.
std::vector<std::array<double, 4>> intrinsicsOf(vk::Device& device, const WorldArray& array, size_t count,
                                                size_t cameras) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::array<double, 4>> intrinsics;
  const std::vector<double> all = numbersOf(device, array, count * 9);
  for (size_t i = 0; i < count; ++i) {
    const double* k = all.data() + 9 * i;
    if (!areFinite({k, 9})) {
      intrinsics.push_back({kNan, kNan, kNan, kNan});
      continue;
    }
    if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) badUsage(kWrongIntrinsics, i / cameras);
    intrinsics.push_back({k[0], k[4], k[2], k[5]});
  }
  return intrinsics;
}

// Replaces some of the factors of all instances by the numbers of arrays.
void setFactors(std::vector<MaterialFactors>& factors, const WorldArrays& a, vk::Device& device) {
  const auto set = [&](const WorldArray& array, size_t channels, const auto& member) {
    if (!array) return;
    const std::vector<double> numbers = numbersOf(device, array, channels * factors.size());
    for (size_t i = 0; i < numbers.size(); ++i)
      member(factors[i / channels], i % channels) = static_cast<float>(numbers[i]);
  };
  set(a.baseColor, 4, [](MaterialFactors& f, size_t channel) -> float& { return f.baseColor[channel]; });
  set(a.metallic, 1, [](MaterialFactors& f, size_t) -> float& { return f.metallic; });
  set(a.roughness, 1, [](MaterialFactors& f, size_t) -> float& { return f.roughness; });
  set(a.emissive, 3, [](MaterialFactors& f, size_t channel) -> float& { return f.emissive[channel]; });
}

}  // namespace

// Returns the same worlds with a list in place of the arrays of lights.
Worlds Scene::Impl::WorldConverter::withLightValues() const {
  Worlds lists = from;
  WorldArrays& a = lists.arrays;
  std::vector<Light> each;
  for (const Handle<Light>& light : from.lights)
    each.push_back(publicLight(scene.scene.lights[scene.index(light)], scene.scene));
  for (uint32_t world = 0; world < from.count; ++world)
    lists.lightValues.insert(lists.lightValues.end(), each.begin(), each.end());
  const auto set = [&](WorldArray& array, size_t channels, const auto& member) {
    if (!array) return;
    const std::vector<double> numbers = numbersOf(device, array, channels * lists.lightValues.size());
    for (size_t i = 0; i < numbers.size(); ++i) member(lists.lightValues[i / channels], i % channels, numbers[i]);
    array = {};
  };
  set(a.lightPosition, 3, [](Light& light, size_t axis, double value) { light.position[axis] = value; });
  set(a.lightDirection, 3,
      [](Light& light, size_t axis, double value) { light.direction[axis] = static_cast<float>(value); });
  set(a.lightColor, 3, [](Light& light, size_t axis, double value) { light.color[axis] = static_cast<float>(value); });
  set(a.lightIntensity, 1, [](Light& light, size_t, double value) { light.intensity = static_cast<float>(value); });
  return lists;
}

// Returns the same worlds with a list in place of the array of material choices.
Worlds Scene::Impl::WorldConverter::withMaterials() const {
  Worlds lists = from;
  const size_t instances = to.instances.size();
  const std::vector<double> choices = numbersOf(device, from.arrays.materialChoice, from.count * instances);
  for (size_t i = 0; i < choices.size(); ++i) {
    if (!(choices[i] >= 0 && choices[i] < static_cast<double>(from.palette.size())))
      badUsage(kWrongChoice, i / instances);
    lists.materials.push_back(from.palette[static_cast<size_t>(choices[i])]);
  }
  lists.arrays.materialChoice = {};
  lists.palette.clear();
  return lists;
}

// Returns the factors of the materials of all instances.
std::vector<MaterialFactors> Scene::Impl::WorldConverter::ownFactors() const {
  std::vector<MaterialFactors> factors;
  for (size_t i = 0; i < from.count * to.instances.size(); ++i) {
    const uint32_t material = from.materials.empty()
                                  ? scene.scene.instances[to.instances[i % to.instances.size()]].material
                                  : scene.index(from.materials[i]);
    const shared::Material& m = scene.scene.materials[material].data;
    factors.push_back({{m.baseColor.r, m.baseColor.g, m.baseColor.b, m.baseColor.a},
                       m.metallic,
                       m.roughness,
                       {m.emissive.r, m.emissive.g, m.emissive.b}});
  }
  return factors;
}

// Returns the same worlds with lists in place of the arrays that shaders would place worlds by.
Worlds Scene::Impl::WorldConverter::withoutArrays() const {
  Worlds lists = from;
  const WorldArrays& a = from.arrays;
  const size_t moved = from.count * to.instances.size(), views = from.count * from.cameras.size();
  const auto expand = [&](const WorldArray& array, std::vector<Transform>& list, size_t count) {
    if (array) list = matricesOf(device, array, count);
  };
  expand(a.transforms, lists.transforms, moved);
  expand(a.previousTransforms, lists.previousTransforms, moved);
  expand(a.nextTransforms, lists.nextTransforms, moved);
  expand(a.cameraToWorld, lists.cameraToWorld, views);
  expand(a.previousCameraToWorld, lists.previousCameraToWorld, views);
  expand(a.nextCameraToWorld, lists.nextCameraToWorld, views);
  if (a.intrinsics) lists.intrinsics = intrinsicsOf(device, a.intrinsics, views, from.cameras.size());
  if (a.exists)
    for (const double value : numbersOf(device, a.exists, moved)) lists.exists.push_back(value != 0);
  if (hasFactors(a)) {
    lists.factors = ownFactors();
    setFactors(lists.factors, a, device);
  }
  if (a.environmentRotation) lists.environmentRotation = numbersOf(device, a.environmentRotation, from.count);
  if (a.environmentIntensity)
    for (const double value : numbersOf(device, a.environmentIntensity, from.count))
      lists.environmentIntensity.push_back(static_cast<float>(value));
  if (a.environmentIndex)
    for (const double index : numbersOf(device, a.environmentIndex, from.count)) {
      checkEnvironmentIndex(index, lists.environmentIndex.size());
      lists.environmentIndex.push_back(static_cast<uint32_t>(index));
    }
  for (const auto array : kOfPlacement) lists.arrays.*array = {};
  return lists;
}

bool hasLights(const WorldArrays& a) {
  return a.lightPosition || a.lightDirection || a.lightColor || a.lightIntensity;
}

bool hasFactors(const WorldArrays& a) {
  return a.baseColor || a.metallic || a.roughness || a.emissive;
}

bool Scene::Impl::WorldConverter::hasArrays() const {
  return std::ranges::any_of(kOfPlacement, [&](const auto array) { return bool(from.arrays.*array); });
}

}  // namespace latelight
