// Checks of worlds.
#include <algorithm>
#include <cmath>

#include "api/device_array.h"
#include "api/settings.h"
#include "api/worlds/converter.h"
#include "api/worlds/messages.h"
#include "api/worlds/world_array.h"

namespace latelight {

namespace {

bool isFinite(const Transform& transform) {
  return areFinite(transform);
}

bool isFinite(const Light& light) {
  const auto finite = [](double value) { return std::isfinite(static_cast<float>(value)); };
  return std::ranges::all_of(light.position, finite) && std::ranges::all_of(light.direction, finite) &&
         std::ranges::all_of(light.color, finite) && finite(light.intensity);
}

bool isFinite(const MaterialFactors& factors) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::ranges::all_of(factors.baseColor, finite) && std::ranges::all_of(factors.emissive, finite) &&
         finite(factors.metallic) && finite(factors.roughness);
}

// `elements`: each world has a value per element, or a single one if it is empty.
void checkCount(size_t has, size_t worlds, size_t each, const char* list, std::string_view elements) {
  if (has == worlds * each || (has == 0 && each != 0)) return;
  badUsage("Worlds::{} must have {} values, one per world{}{}, and has {}", list, worlds * each,
           elements.empty() ? "" : " and ", elements, has);
}

// Checks the arrays of a call.
struct ArrayChecker {
  const vk::Device& device;
  uint32_t worlds;

  // `numbers`: per world. `hasList`: a list of Worlds describes the same.
  void check(const WorldArray& array, bool hasList, ElementKind kind, uint64_t numbers, const char* name) const {
    if (!array) return;
    if (hasList) badUsage("Worlds::{} and Worlds::arrays.{} describe the same: omit one of them", name, name);
    checkWorldArray(array, kind, device, fmt::format("Worlds::arrays.{}", name));
    if (array.device &&
        !DeviceArrayMemory::contains(*array.device, array.offset, worlds, numbers * elementBytes(array)))
      badUsage("Worlds::arrays.{} must have {} numbers in each of {} worlds, which extend beyond its memory", name,
               numbers, worlds);
  }
  // Matrices of 3 or 4 rows, `count` per world.
  void checkMatrices(const WorldArray& array, bool hasList, uint64_t count, const char* name) const {
    if (array && array.rows != 3 && array.rows != 4)
      badUsage("matrices of Worlds::arrays must have 3 or 4 rows, not {}", array.rows);
    check(array, hasList, ElementKind::Numbers, 4 * uint64_t{array.rows} * count, name);
  }
};

}  // namespace

void Scene::Impl::WorldConverter::check() const {
  if (from.count == 0) badUsage("Worlds::count must be at least 1");
  if (from.cameras.empty()) badUsage("Worlds::cameras must have at least one camera");
  const size_t instances = to.instances.size(), cameras = from.cameras.size();
  checkCount(from.transforms.size(), from.count, instances, "transforms", "instance");
  checkCount(from.previousTransforms.size(), from.count, instances, "previousTransforms", "instance");
  checkCount(from.nextTransforms.size(), from.count, instances, "nextTransforms", "instance");
  checkCount(from.exists.size(), from.count, instances, "exists", "instance");
  checkCount(from.materials.size(), from.count, instances, "materials", "instance");
  checkCount(from.factors.size(), from.count, instances, "factors", "instance");
  checkCount(from.lightValues.size(), from.count, from.lights.size(), "lightValues", "light");
  checkCount(from.environmentRotation.size(), from.count, 1, "environmentRotation", "");
  checkCount(from.environmentIntensity.size(), from.count, 1, "environmentIntensity", "");
  checkCount(from.environmentIndex.size(), from.count, 1, "environmentIndex", "");
  if ((from.environmentIndex.empty() && !from.arrays.environmentIndex) != from.environments.empty())
    badUsage("Worlds::environments and Worlds::environmentIndex require each other");
  for (size_t world = 0; world < from.environmentIndex.size(); ++world)
    checkEnvironmentIndex(from.environmentIndex[world], world);
  checkCount(from.cameraToWorld.size(), from.count, cameras, "cameraToWorld", "camera");
  checkCount(from.previousCameraToWorld.size(), from.count, cameras, "previousCameraToWorld", "camera");
  checkCount(from.nextCameraToWorld.size(), from.count, cameras, "nextCameraToWorld", "camera");
  checkCount(from.intrinsics.size(), from.count, cameras, "intrinsics", "camera");
  const WorldArrays& a = from.arrays;
  const bool moved =
      !from.previousTransforms.empty() || !from.nextTransforms.empty() || a.previousTransforms || a.nextTransforms;
  if (moved && from.transforms.empty() && !a.transforms)
    badUsage("previous and next transforms of worlds require transforms");
  checkArrays();
  if (!from.cameraInstances.empty() && from.cameraInstances.size() != cameras)
    badUsage("the instances that cameras ride on must be listed with one value per camera, {}, not {}", cameras,
             from.cameraInstances.size());
}

void Scene::Impl::WorldConverter::checkArrays() const {
  const WorldArrays& a = from.arrays;
  const ArrayChecker checker{device, from.count};
  const uint64_t instances = to.instances.size(), cameras = from.cameras.size(), lights = from.lights.size();
  checker.checkMatrices(a.transforms, !from.transforms.empty(), instances, "transforms");
  checker.checkMatrices(a.previousTransforms, !from.previousTransforms.empty(), instances, "previousTransforms");
  checker.checkMatrices(a.nextTransforms, !from.nextTransforms.empty(), instances, "nextTransforms");
  checker.check(a.exists, !from.exists.empty(), ElementKind::Mask, instances, "exists");
  checker.checkMatrices(a.cameraToWorld, !from.cameraToWorld.empty(), cameras, "cameraToWorld");
  checker.checkMatrices(a.previousCameraToWorld, !from.previousCameraToWorld.empty(), cameras, "previousCameraToWorld");
  checker.checkMatrices(a.nextCameraToWorld, !from.nextCameraToWorld.empty(), cameras, "nextCameraToWorld");
  checker.check(a.intrinsics, !from.intrinsics.empty(), ElementKind::Numbers, 9 * cameras, "intrinsics");
  const auto numbers = [&](const WorldArray& array, bool hasList, uint64_t count, const char* name) {
    checker.check(array, hasList, ElementKind::Numbers, count, name);
  };
  const bool hasFactors = !from.factors.empty(), hasLightValues = !from.lightValues.empty();
  numbers(a.baseColor, hasFactors, 4 * instances, "baseColor");
  numbers(a.metallic, hasFactors, instances, "metallic");
  numbers(a.roughness, hasFactors, instances, "roughness");
  numbers(a.emissive, hasFactors, 3 * instances, "emissive");
  numbers(a.environmentRotation, !from.environmentRotation.empty(), 1, "environmentRotation");
  numbers(a.environmentIntensity, !from.environmentIntensity.empty(), 1, "environmentIntensity");
  checker.check(a.environmentIndex, !from.environmentIndex.empty(), ElementKind::Integers, 1, "environmentIndex");
  checker.check(a.materialChoice, !from.materials.empty(), ElementKind::Integers, instances, "materialChoice");
  numbers(a.lightPosition, hasLightValues, 3 * lights, "lightPosition");
  numbers(a.lightDirection, hasLightValues, 3 * lights, "lightDirection");
  numbers(a.lightColor, hasLightValues, 3 * lights, "lightColor");
  numbers(a.lightIntensity, hasLightValues, lights, "lightIntensity");
  if (hasLights(a) && from.lights.empty()) badUsage("arrays of lights require Worlds::lights, which they describe");
  if (bool(a.materialChoice) == from.palette.empty())
    badUsage("Worlds::palette and Worlds::arrays.materialChoice require each other");
}

void Scene::Impl::WorldConverter::checkEnvironmentIndex(double index, size_t world) const {
  if (!(index >= 0 && index < static_cast<double>(from.environments.size()))) badUsage(kWrongEnvironmentIndex, world);
}

size_t Scene::Impl::WorldConverter::vertexCount() const {
  size_t count = 0;
  for (const Handle<Mesh>& mesh : from.meshes) count += scene.scene.meshes[scene.index(mesh)].positions.size();
  return count;
}

void Scene::Impl::WorldConverter::checkDeformations() const {
  const WorldArrays& a = from.arrays;
  const ArrayChecker checker{device, from.count};
  const uint64_t joints = from.joints.size(), vertexNumbers = 3 * vertexCount();
  checker.checkMatrices(a.jointTransforms, false, joints, "jointTransforms");
  checker.checkMatrices(a.previousJointTransforms, false, joints, "previousJointTransforms");
  checker.checkMatrices(a.nextJointTransforms, false, joints, "nextJointTransforms");
  checker.check(a.vertices, false, ElementKind::Numbers, vertexNumbers, "vertices");
  checker.check(a.previousVertices, false, ElementKind::Numbers, vertexNumbers, "previousVertices");
  checker.check(a.nextVertices, false, ElementKind::Numbers, vertexNumbers, "nextVertices");
  if (bool(a.jointTransforms) == from.joints.empty())
    badUsage("Worlds::joints and Worlds::arrays.jointTransforms require each other");
  if (bool(a.vertices) == from.meshes.empty())
    badUsage("Worlds::meshes and Worlds::arrays.vertices require each other");
  if ((a.previousJointTransforms || a.nextJointTransforms) && !a.jointTransforms)
    badUsage("Worlds::arrays.previousJointTransforms and nextJointTransforms require jointTransforms");
  if ((a.previousVertices || a.nextVertices) && !a.vertices)
    badUsage("Worlds::arrays.previousVertices and nextVertices require vertices");
  if ((a.jointTransforms || a.vertices) && !render::WorldDeformer::runsOn(device))
    fail(ExitCode::NoDevice, "{} has no 64-bit floats in shaders, which joints and vertices of worlds require",
         device.info().name);
}

// Claims the host memory of the call's views and of the converted lists, before anything of that size is allocated.
MemoryClaim Scene::Impl::WorldConverter::claim(bool onDevice) const {
  const WorldArrays& a = from.arrays;
  const uint64_t count = from.count, views = count * from.cameras.size(), instances = count * to.instances.size();
  checkIndexable("cameras", 16 * views);
  const auto times = [](const auto&... given) { return (uint64_t{0} + ... + uint64_t{given}); };
  uint64_t bytes = count;  // `invalid`
  if (onDevice) {
    checkIndexable("instances", 16 * instances);
    checkIndexable("lights", 3 * count * from.lights.size());
    bytes += views * sizeof(shared::View);
  } else {
    const bool ride = !from.cameraInstances.empty();
    const uint64_t poses = times(true, ride || a.previousCameraToWorld || !from.previousCameraToWorld.empty(),
                                 ride || a.nextCameraToWorld || !from.nextCameraToWorld.empty());
    const uint64_t transforms =
        times(a.transforms || !from.transforms.empty(), a.previousTransforms || !from.previousTransforms.empty(),
              a.nextTransforms || !from.nextTransforms.empty());
    bytes += views * poses * kCameraBytes + instances * transforms * sizeof(glm::dmat4);
  }
  return {bytes, fmt::format("the {} views of {} worlds", views, count)};
}

// A world with a value that is not finite has no instances. Its cameras see only the background.
void Scene::Impl::WorldConverter::findInvalid(bool onDevice) {
  invalid.assign(from.count, 0);
  const auto mark = [&](const std::vector<Transform>& values) {
    for (size_t i = 0; i < values.size(); ++i)
      if (!isFinite(values[i])) invalid[i / (values.size() / from.count)] = 1;
  };
  if (!onDevice)
    for (const auto* values : {&from.transforms, &from.previousTransforms, &from.nextTransforms, &from.cameraToWorld,
                               &from.previousCameraToWorld, &from.nextCameraToWorld})
      mark(*values);
  for (size_t i = 0; i < from.factors.size(); ++i)
    if (!isFinite(from.factors[i])) invalid[i / to.instances.size()] = 1;
  for (size_t i = 0; i < from.lightValues.size(); ++i)
    if (!isFinite(from.lightValues[i])) invalid[i / from.lights.size()] = 1;
  for (size_t world = 0; world < from.environmentRotation.size(); ++world)
    if (!areFinite({&from.environmentRotation[world], 1})) invalid[world] = 1;
  for (size_t world = 0; world < from.environmentIntensity.size(); ++world)
    if (!std::isfinite(from.environmentIntensity[world])) invalid[world] = 1;
  for (size_t i = 0; !onDevice && i < from.intrinsics.size(); ++i)
    if (!areFinite(from.intrinsics[i])) invalid[i / from.cameras.size()] = 1;
}

// Finds the worlds with joints or vertices that are not finite. `keep`: keeps the numbers.
void Scene::Impl::WorldConverter::checkNumbers(const WorldArray& joints, const WorldArray& vertices, bool keep) {
  if (joints) {
    const std::vector<Transform> matrices = matricesOf(device, joints, from.count * from.joints.size());
    for (size_t i = 0; i < matrices.size(); ++i) {
      if (!isFinite(matrices[i]))
        invalid[i / from.joints.size()] = 1;
      else if (!std::ranges::equal(std::span(matrices[i]).last<4>(), std::array{0.0, 0.0, 0.0, 1.0}))
        badUsage(kWrongJoint, i / from.joints.size());
      if (keep)
        to.deformations.jointNumbers.insert(to.deformations.jointNumbers.end(), matrices[i].begin(), matrices[i].end());
    }
  }
  if (!vertices) return;
  std::vector<double> numbers = numbersOf(device, vertices, 3 * from.count * vertexCount());
  for (size_t i = 0; i < numbers.size(); ++i)
    if (!std::isfinite(static_cast<float>(numbers[i]))) invalid[i / (numbers.size() / from.count)] = 1;
  if (keep) to.deformations.vertexNumbers = std::move(numbers);
}

}  // namespace latelight
