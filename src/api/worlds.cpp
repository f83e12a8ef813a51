// Worlds of the public API: checks the lists, and converts them to the renderer's instances and cameras of all worlds.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <numeric>

#include "api/device_array.h"
#include "api/scene.h"
#include "api/settings.h"
#include "api/world_array.h"
#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "render/settings/settings.h"
#include "render/submit/renderer.h"
#include "render/submit/scene_state.h"
#include "render/submit/session.h"
#include "scene/edit_check.h"
#include "scene/file_frame.h"
#include "scene/lens.h"
#include "vk/read_back.h"

namespace latelight {

namespace {

constexpr char kWrongJoint[] =
    "the transform of a joint must have the last row 0 0 0 1, and one of world {} has another";
constexpr char kWrongIntrinsics[] =
    "a camera matrix k must have focal lengths above 0, no skew and the last row 0 0 1, and one in world {} does not";
constexpr char kWrongFactors[] =
    "factors of materials must be at least 0, and metallic and roughness at most 1, and one of world {} is not";
constexpr char kWrongEnvironmentIndex[] =
    "the environments of worlds must be indices in the list of environments, and that of world {} is not";
constexpr char kWrongChoice[] = "material choices must be indices in the list of materials, and one of world {} is not";
constexpr char kWrongEnvironment[] = "the intensity of the environment must be at least 0, and that of world {} is not";

// Calls `convert` for a world, which the message of a rejected value names.
template <typename Convert>
void inWorld(size_t world, const Convert& convert) {
  try {
    convert();
  } catch (const Error& error) {
    if (error.code() != ExitCode::Usage) throw;
    throw Error(ExitCode::Usage, fmt::format("world {}: {}", world, error.what()));
  }
}

// As floats.
bool areFinite(std::span<const double> values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(static_cast<float>(value)); });
}
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

// The ranges that glTF 2.0 gives factors, except that colors may exceed 1.
bool areInRange(const MaterialFactors& factors) {
  const auto isColor = [](float value) { return value >= 0; };
  const auto isShare = [](float value) { return value >= 0 && value <= 1; };
  return std::ranges::all_of(factors.baseColor, isColor) && std::ranges::all_of(factors.emissive, isColor) &&
         isShare(factors.metallic) && isShare(factors.roughness);
}

// `elements`: each world has a value per element, or a single one if it is empty.
void checkCount(size_t has, size_t worlds, size_t each, const char* list, std::string_view elements) {
  if (has == worlds * each || (has == 0 && each != 0)) return;
  badUsage("Worlds::{} must have {} values, one per world{}{}, and has {}", list, worlds * each,
           elements.empty() ? "" : " and ", elements, has);
}

// Returns the indices of the worlds' environments. `count`: of Worlds::environments.
template <typename Number>
std::vector<uint32_t> environmentIndices(const std::vector<Number>& indices, size_t count) {
  std::vector<uint32_t> checked;
  for (size_t world = 0; world < indices.size(); ++world) {
    const auto index = static_cast<double>(indices[world]);
    if (!(index >= 0 && index < static_cast<double>(count))) badUsage(kWrongEnvironmentIndex, world);
    checked.push_back(static_cast<uint32_t>(index));
  }
  return checked;
}

// --- arrays ----------------------------------------------------------------------------------------------------------

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

// Copies an array of the device's memory to the host, after everything that was submitted.
std::vector<std::byte> readBack(vk::Device& device, const WorldArray& array, uint64_t bytes) {
  std::vector<std::byte> host(bytes);
  vk::readBack(device, DeviceArrayMemory::bufferOf(*array.device), array.offset, host);
  return host;
}

// Returns `count` elements of an array as doubles.
std::vector<double> numbersOf(vk::Device& device, const WorldArray& array, size_t count) {
  std::vector<std::byte> copied;
  const void* numbers = array.host;
  if (array.device) numbers = (copied = readBack(device, array, count * elementBytes(array))).data();
  const auto all = [&]<typename T>(const T* from) { return std::vector<double>(from, from + count); };
  using enum WorldArray::Element;
  if (array.element == Float64) return all(static_cast<const double*>(numbers));
  if (array.element == Float32) return all(static_cast<const float*>(numbers));
  if (array.element == Int32) return all(static_cast<const int32_t*>(numbers));
  if (array.element == Int64) return all(static_cast<const int64_t*>(numbers));
  return all(static_cast<const uint8_t*>(numbers));
}

uint32_t elementOf(const WorldArray& array) {
  using enum WorldArray::Element;
  if (array.element == Int32) return shared::kNumberInt;
  if (array.element == Int64) return shared::kNumberLong;
  return array.element == Float64 ? shared::kNumberDouble : shared::kNumberFloat;
}

std::vector<Transform> matricesOf(vk::Device& device, const WorldArray& array, size_t count) {
  const size_t size = 4 * array.rows;
  const std::vector<double> numbers = numbersOf(device, array, count * size);
  std::vector<Transform> matrices(count, Transform{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1});
  for (size_t i = 0; i < count; ++i)
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(i * size), size, matrices[i].begin());
  return matrices;
}

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

bool hasLights(const WorldArrays& a) {
  return a.lightPosition || a.lightDirection || a.lightColor || a.lightIntensity;
}

// The memory of a call's arrays. The host's arrays are copied to one buffer, in two steps: their sizes are added first.
class InputWriter {
 public:
  // Gives the address of an array, which is the caller's own if it is in the device's memory.
  void give(const WorldArray& array, uint64_t bytes, VkDeviceAddress& address,
            std::vector<std::shared_ptr<const void>>& held) {
    if (array.host) add(array.host, bytes, address);
    if (!array.device) return;
    held.push_back(DeviceArrayMemory::held(*array.device));
    address = DeviceArrayMemory::bufferOf(*array.device).address() + array.offset;
  }
  // The memory must stay valid until write().
  void add(const void* from, uint64_t bytes, VkDeviceAddress& address) {
    parts_.push_back({from, bytes, total_, &address});
    total_ += (bytes + 15) / 16 * 16;
  }
  void write(render::Renderer& renderer, std::vector<std::shared_ptr<const void>>& held) {
    if (parts_.empty()) return;
    const std::shared_ptr<const vk::Buffer> memory = renderer.inputMemory(total_);
    std::vector<MemoryCopy> copies;
    for (const Part& part : parts_) {
      copies.push_back({memory->mapped() + part.offset, static_cast<const std::byte*>(part.from), part.bytes});
      *part.address = memory->address() + part.offset;
    }
    copyInParallel(copies);
    held.push_back(memory);
  }

 private:
  struct Part {
    const void* from;
    uint64_t bytes, offset;
    VkDeviceAddress* address;
  };
  std::vector<Part> parts_;
  uint64_t total_ = 0;
};

// Shaders index arrays with 32 bits.
void checkIndexable(const char* things, uint64_t numbers) {
  if (numbers > std::numeric_limits<uint32_t>::max())
    badUsage("an array that describes {} of worlds must have fewer than 2^32 numbers: render fewer worlds per call",
             things);
}

}  // namespace

// Converts one call's worlds.
struct Scene::Impl::WorldConverter {
  const Worlds& from;
  const Impl& scene;
  const render::Settings& settings;
  render::WorldStates& to;
  std::vector<uint32_t> placeOf{};  // index in `instances` per instance of the scene; ~0u: not listed
  std::vector<uint8_t> invalid{};   // per world

  void check(const vk::Device& device) const;
  void checkArrays(const vk::Device& device) const;
  void checkNumbers(vk::Device& device, const WorldArray& joints, const WorldArray& vertices, bool keep);
  bool placesLights() const;
  Worlds withLightValues(vk::Device& device) const;
  Worlds withMaterials(vk::Device& device) const;
  Lens lensWith(const Camera& camera, const std::array<double, 4>& intrinsics) const;
  bool hasIntrinsics() const { return from.arrays.intrinsics || !from.intrinsics.empty(); }
  void listInstances();
  void checkDeformations(const vk::Device& device) const;
  MemoryClaim claim(bool onDevice) const;
  void listDeformations(render::Renderer& renderer, vk::Device& device, bool onDevice);
  void findInvalid(bool onDevice);
  size_t vertexCount() const;
  // For shaders that place the worlds.
  std::vector<scene::Camera> camerasOfWorld() const;
  void give(render::Renderer& renderer, std::vector<scene::Camera> cameras) const;
  std::vector<MaterialFactors> ownFactors() const;
  void convertMaterials() const;
  void convertLights() const;
  std::vector<glm::dmat4> transformsOf(const std::vector<Transform>& values) const;
  glm::dmat4 frameOf(uint32_t instance, uint32_t world, const std::vector<glm::dmat4>& transforms,
                     const std::vector<glm::dmat4>& scenes) const;
  std::vector<scene::Camera> camerasAt(const std::vector<Transform>& poses, const std::vector<glm::dmat4>& transforms,
                                       const scene::Pose& pose) const;
};

void Scene::Impl::WorldConverter::check(const vk::Device& device) const {
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
  environmentIndices(from.environmentIndex, from.environments.size());
  checkCount(from.cameraToWorld.size(), from.count, cameras, "cameraToWorld", "camera");
  checkCount(from.previousCameraToWorld.size(), from.count, cameras, "previousCameraToWorld", "camera");
  checkCount(from.nextCameraToWorld.size(), from.count, cameras, "nextCameraToWorld", "camera");
  checkCount(from.intrinsics.size(), from.count, cameras, "intrinsics", "camera");
  const WorldArrays& a = from.arrays;
  const bool moved =
      !from.previousTransforms.empty() || !from.nextTransforms.empty() || a.previousTransforms || a.nextTransforms;
  if (moved && from.transforms.empty() && !a.transforms)
    badUsage("previous and next transforms of worlds require transforms");
  checkArrays(device);
  if (!from.cameraInstances.empty() && from.cameraInstances.size() != cameras)
    badUsage("the instances that cameras ride on must be listed with one value per camera, {}, not {}", cameras,
             from.cameraInstances.size());
}

void Scene::Impl::WorldConverter::checkArrays(const vk::Device& device) const {
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

size_t Scene::Impl::WorldConverter::vertexCount() const {
  size_t count = 0;
  for (const Handle<Mesh>& mesh : from.meshes) count += scene.scene.meshes[scene.index(mesh)].positions.size();
  return count;
}

void Scene::Impl::WorldConverter::checkDeformations(const vk::Device& device) const {
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

// Gives the arrays of joints and vertices to the shaders that deform meshes. If the host places the worlds, it has
// their numbers, too, for the bounds.
void Scene::Impl::WorldConverter::listDeformations(render::Renderer& renderer, vk::Device& device, bool onDevice) {
  const WorldArrays& a = from.arrays;
  render::WorldDeformations& given = to.deformations;
  for (const std::string& path : from.joints) {
    given.joints.push_back(scene.jointOf(path));
    if (std::ranges::count(given.joints, given.joints.back()) > 1)
      badUsage("the joints of worlds must be listed once each, and the node {} is listed twice", path);
  }
  for (const Handle<Mesh>& mesh : from.meshes) {
    given.meshes.push_back(scene.index(mesh));
    if (std::ranges::count(given.meshes, given.meshes.back()) > 1)
      badUsage("the meshes of worlds must be listed once each, and one is listed twice");
  }
  const size_t joints = from.count * from.joints.size(), vertices = from.count * vertexCount();
  checkIndexable("joints", 16 * joints);
  checkIndexable("vertices", 3 * vertices);
  InputWriter writer;
  const auto give = [&](const WorldArray& array, size_t count, uint32_t numbers, render::WorldArray& to) {
    if (!array) return;
    to = {.address = 0, .rows = array.rows, .element = elementOf(array)};
    writer.give(array, count * numbers * elementBytes(array), to.address, given.memory);
  };
  const WorldArray* ofJoints[] = {&a.jointTransforms, &a.previousJointTransforms, &a.nextJointTransforms};
  const WorldArray* ofVertices[] = {&a.vertices, &a.previousVertices, &a.nextVertices};
  for (size_t time = 0; time < 3; ++time) {
    give(*ofJoints[time], joints, 4 * ofJoints[time]->rows, given.jointTransforms[time]);
    give(*ofVertices[time], vertices, 3, given.vertices[time]);
    if (!onDevice) checkNumbers(device, *ofJoints[time], *ofVertices[time], time == 0);
  }
  writer.write(renderer, given.memory);
}

// Finds the worlds with joints or vertices that are not finite. `keep`: keeps the numbers.
void Scene::Impl::WorldConverter::checkNumbers(vk::Device& device, const WorldArray& joints, const WorldArray& vertices,
                                               bool keep) {
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

// Returns true if shaders may convert the arrays of lights. The host turns the shapes of area lights.
bool Scene::Impl::WorldConverter::placesLights() const {
  const auto isArea = [&](const Handle<Light>& light) {
    return shared::lightIsArea(scene.scene.lights[scene.index(light)].type);
  };
  if (from.arrays.lightDirection && std::ranges::any_of(from.lights, isArea)) return false;
  return scene.scene.lights.size() + settings.sun.has_value() <= shared::kMaxPlacedLights;
}

// Returns the same worlds with a list in place of the arrays of lights.
Worlds Scene::Impl::WorldConverter::withLightValues(vk::Device& device) const {
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
Worlds Scene::Impl::WorldConverter::withMaterials(vk::Device& device) const {
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

void Scene::Impl::WorldConverter::listInstances() {
  to.count = from.count;
  for (const Handle<Instance>& instance : from.instances) to.instances.push_back(scene.index(instance));
  if (from.instances.empty())
    for (uint32_t i = 0; i < scene.scene.instances.size(); ++i)
      if (!scene.scene.instances[i].removed) to.instances.push_back(i);
  placeOf.assign(scene.scene.instances.size(), ~0u);
  for (uint32_t i = 0; i < to.instances.size(); ++i) {
    if (placeOf[to.instances[i]] != ~0u)
      badUsage("the instances of worlds must be listed once each, and one is listed twice");
    placeOf[to.instances[i]] = i;
  }
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
    if (!std::isfinite(from.environmentRotation[world])) invalid[world] = 1;
  for (size_t world = 0; world < from.environmentIntensity.size(); ++world)
    if (!std::isfinite(from.environmentIntensity[world])) invalid[world] = 1;
  for (size_t i = 0; !onDevice && i < from.intrinsics.size(); ++i)
    if (!areFinite(from.intrinsics[i])) invalid[i / from.cameras.size()] = 1;
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

void Scene::Impl::WorldConverter::convertMaterials() const {
  for (const Handle<Material>& material : from.materials) to.materials.push_back(scene.index(material));
  for (size_t i = 0; i < from.factors.size(); ++i) {
    const size_t world = i / to.instances.size();
    const MaterialFactors values = invalid[world] ? MaterialFactors{} : from.factors[i];
    if (!areInRange(values)) badUsage(kWrongFactors, world);
    const auto [r, g, b, alpha] = values.baseColor;
    const auto [x, y, z] = values.emissive;
    to.factors.push_back({.baseColor = {r, g, b, alpha},
                          .emissive = {x, y, z},
                          .metallic = values.metallic,
                          .roughness = values.roughness});
  }
}

void Scene::Impl::WorldConverter::convertLights() const {
  for (const Handle<Light>& light : from.lights) {
    to.lights.push_back(scene.index(light));
    if (std::ranges::count(to.lights, to.lights.back()) > 1)
      badUsage("the lights of worlds must be listed once each, and one is listed twice");
  }
  for (size_t i = 0; i < from.lightValues.size(); ++i) {
    const scene::Light& like = scene.scene.lights[to.lights[i % to.lights.size()]];
    if (invalid[i / to.lights.size()]) {
      to.lightValues.push_back(like);
      continue;
    }
    inWorld(i / to.lights.size(), [&] {
      to.lightValues.push_back(internalLight(from.lightValues[i], scene.scene, like));
      scene::checkLight(scene.scene, to.lightValues.back());
    });
  }
  to.environmentIndex = from.environmentIndex;
  for (size_t world = 0; world < from.environmentRotation.size(); ++world)
    to.environmentRotation.push_back(render::radians(invalid[world] ? 0 : from.environmentRotation[world]));
  for (size_t world = 0; world < from.environmentIntensity.size(); ++world) {
    const float intensity = invalid[world] ? 0 : from.environmentIntensity[world];
    if (intensity < 0) badUsage(kWrongEnvironment, world);
    to.environmentIntensity.push_back(intensity);
  }
}

std::vector<glm::dmat4> Scene::Impl::WorldConverter::transformsOf(const std::vector<Transform>& values) const {
  std::vector<glm::dmat4> transforms;
  transforms.reserve(values.size());
  const size_t each = to.instances.size();
  for (size_t i = 0; i < values.size(); ++i) {
    transforms.push_back(invalid[i / each] ? glm::dmat4(1) : internalTransform(values[i], scene.scene));
    inWorld(i / each, [&] { scene::checkTransform(transforms.back()); });
  }
  return transforms;
}

// Returns the instance's frame in a world, without scale, in the renderer's world space. `scenes`: the transforms of
// the scene's instances.
glm::dmat4 Scene::Impl::WorldConverter::frameOf(uint32_t instance, uint32_t world,
                                                const std::vector<glm::dmat4>& transforms,
                                                const std::vector<glm::dmat4>& scenes) const {
  const uint32_t place = placeOf[instance];
  const bool own = place != ~0u && !transforms.empty();
  glm::dmat4 frame = own ? transforms[size_t{world} * to.instances.size() + place] : scenes[instance];
  for (int i = 0; i < 3; ++i) {
    const double length = glm::length(glm::dvec3(frame[i]));
    if (!(length > 0)) badUsage("a camera rides on an instance whose transform has an axis of length 0");
    frame[i] /= length;
  }
  if (glm::determinant(glm::dmat3(frame)) < 0) badUsage("a camera rides on an instance whose transform mirrors");
  return frame;
}

// Returns the camera's lens with another camera matrix: fx, fy, cx and cy, in pixels of the call's images. A camera
// without a lens gets a pinhole.
Lens Scene::Impl::WorldConverter::lensWith(const Camera& camera, const std::array<double, 4>& intrinsics) const {
  Lens lens = camera.lens.value_or(Lens{});
  const scene::LensModelInfo& model = scene::infoOf(static_cast<scene::LensModel>(lens.model));
  if (!model.calibrated)
    badUsage("a camera with the lens model {} has no focal lengths, which camera matrices of worlds would replace",
             model.name);
  if (camera.orthographic)
    badUsage("an orthographic camera has no focal lengths, which camera matrices of worlds would replace");
  lens.width = settings.width;
  lens.height = settings.height;
  lens.fx = intrinsics[0];
  lens.fy = intrinsics[1];
  lens.cx = intrinsics[2];
  lens.cy = intrinsics[3];
  return lens;
}

// `poses` replaces the cameras' own poses unless it is empty. `transforms` and `pose` are those of the same time.
std::vector<scene::Camera> Scene::Impl::WorldConverter::camerasAt(const std::vector<Transform>& poses,
                                                                  const std::vector<glm::dmat4>& transforms,
                                                                  const scene::Pose& pose) const {
  std::vector<scene::Camera> cameras;
  const size_t each = from.cameras.size();
  cameras.reserve(from.count * each);
  std::vector<glm::dmat4> scenes;  // transforms of the scene's instances
  if (!from.cameraInstances.empty()) scenes = scene::instanceTransforms(scene.scene, pose);
  for (size_t i = 0; i < from.count * each; ++i) {
    const auto world = static_cast<uint32_t>(i / each);
    Camera camera = from.cameras[i % each];
    if (!poses.empty() && !invalid[world]) camera.cameraToWorld = poses[i];
    if (!from.intrinsics.empty() && !invalid[world]) {
      const auto [fx, fy, cx, cy] = from.intrinsics[i];
      if (!(fx > 0 && fy > 0)) badUsage(kWrongIntrinsics, world);
      camera.lens = lensWith(camera, from.intrinsics[i]);
    }
    inWorld(world, [&] {
      scene::Camera internal = render::fitted(internalCamera(camera, scene.scene), settings.cameraFit);
      const bool rides = !from.cameraInstances.empty() && from.cameraInstances[i % each];
      if (rides) {
        // The pose relative to the instance's frame, in the renderer's axes.
        const glm::dmat4 relative = glm::inverse(scene::worldFromFile(scene.scene)) * internal.toWorld;
        internal.toWorld = frameOf(scene.index(*from.cameraInstances[i % each]), world, transforms, scenes) * relative;
      }
      internal.world = world;
      cameras.push_back(std::move(internal));
    });
  }
  return cameras;
}

// The cameras of each world, with poses of their own.
std::vector<scene::Camera> Scene::Impl::WorldConverter::camerasOfWorld() const {
  std::vector<scene::Camera> cameras;
  for (Camera camera : from.cameras) {
    const double width = settings.width;
    if (hasIntrinsics()) camera.lens = lensWith(camera, {width, width, 0, 0});
    cameras.push_back(render::fitted(internalCamera(camera, scene.scene), settings.cameraFit));
  }
  return cameras;
}

// Gives the arrays, or the lists as arrays, to the shaders that place the worlds.
void Scene::Impl::WorldConverter::give(render::Renderer& renderer, std::vector<scene::Camera> cameras) const {
  const WorldArrays& arrays = from.arrays;
  render::WorldInputs& inputs = to.inputs.emplace();
  const size_t instances = from.count * to.instances.size(), views = from.count * cameras.size();
  inputs.cameras = std::move(cameras);
  InputWriter writer;
  const auto giveArray = [&](const WorldArray& array, uint64_t bytes, VkDeviceAddress& address) {
    writer.give(array, bytes, address, inputs.memory);
  };
  const auto matrices = [&](const WorldArray& array, const std::vector<Transform>& list, size_t count,
                            render::WorldArray& given) {
    given.rows = array ? array.rows : 4;
    given.element = array ? elementOf(array) : shared::kNumberDouble;
    if (!list.empty()) writer.add(list.data(), list.size() * sizeof(Transform), given.address);
    giveArray(array, count * given.rows * 4 * elementBytes(array), given.address);
  };
  matrices(arrays.transforms, from.transforms, instances, inputs.transforms);
  matrices(arrays.previousTransforms, from.previousTransforms, instances, inputs.previous);
  matrices(arrays.nextTransforms, from.nextTransforms, instances, inputs.next);
  matrices(arrays.cameraToWorld, from.cameraToWorld, views, inputs.cameraToWorld);
  matrices(arrays.previousCameraToWorld, from.previousCameraToWorld, views, inputs.previousCameraToWorld);
  matrices(arrays.nextCameraToWorld, from.nextCameraToWorld, views, inputs.nextCameraToWorld);
  const auto numbers = [&](const WorldArray& array, size_t count, render::WorldArray& given) {
    given.element = elementOf(array);
    giveArray(array, count * elementBytes(array), given.address);
  };
  numbers(arrays.baseColor, 4 * instances, inputs.baseColor);
  numbers(arrays.metallic, instances, inputs.metallic);
  numbers(arrays.roughness, instances, inputs.roughness);
  numbers(arrays.emissive, 3 * instances, inputs.emissive);
  numbers(arrays.materialChoice, instances, inputs.materialChoice);
  for (const Handle<Material>& material : from.palette) inputs.palette.push_back(scene.index(material));
  const size_t lights = from.count * from.lights.size();
  numbers(arrays.lightPosition, 3 * lights, inputs.lightPosition);
  numbers(arrays.lightDirection, 3 * lights, inputs.lightDirection);
  numbers(arrays.lightColor, 3 * lights, inputs.lightColor);
  numbers(arrays.lightIntensity, lights, inputs.lightIntensity);
  for (const uint32_t light : to.lights) {
    const scene::Light& like = scene.scene.lights[light];
    inputs.lights.push_back(internalLight(publicLight(like, scene.scene), scene.scene, like));
  }
  numbers(arrays.environmentRotation, from.count, inputs.environmentRotation);
  numbers(arrays.environmentIntensity, from.count, inputs.environmentIntensity);
  numbers(arrays.environmentIndex, from.count, inputs.environmentIndex);
  if (!from.exists.empty()) writer.add(from.exists.data(), from.exists.size(), inputs.exists);
  giveArray(arrays.exists, instances, inputs.exists);
  std::vector<double> k;
  for (const auto& [fx, fy, cx, cy] : from.intrinsics) k.insert(k.end(), {fx, 0, cx, 0, fy, cy, 0, 0, 1});
  inputs.intrinsics.element = k.empty() ? elementOf(arrays.intrinsics) : shared::kNumberDouble;
  if (!k.empty()) writer.add(k.data(), k.size() * sizeof(double), inputs.intrinsics.address);
  giveArray(arrays.intrinsics, views * 9 * elementBytes(arrays.intrinsics), inputs.intrinsics.address);
  for (const std::optional<Handle<Instance>>& ride : from.cameraInstances)
    inputs.rides.push_back(ride ? scene.index(*ride) : ~0u);
  writer.write(renderer, inputs.memory);
}

namespace {

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

// Returns the same worlds with lists in place of arrays. `factors`: those of all instances without the arrays.
Worlds withoutArrays(const Worlds& worlds, vk::Device& device, size_t instances, std::vector<MaterialFactors> factors) {
  Worlds lists = worlds;
  const WorldArrays& a = worlds.arrays;
  const size_t moved = worlds.count * instances, views = worlds.count * worlds.cameras.size();
  const auto expand = [&](const WorldArray& array, std::vector<Transform>& list, size_t count) {
    if (array) list = matricesOf(device, array, count);
  };
  expand(a.transforms, lists.transforms, moved);
  expand(a.previousTransforms, lists.previousTransforms, moved);
  expand(a.nextTransforms, lists.nextTransforms, moved);
  expand(a.cameraToWorld, lists.cameraToWorld, views);
  expand(a.previousCameraToWorld, lists.previousCameraToWorld, views);
  expand(a.nextCameraToWorld, lists.nextCameraToWorld, views);
  if (a.intrinsics) lists.intrinsics = intrinsicsOf(device, a.intrinsics, views, worlds.cameras.size());
  if (a.exists)
    for (const double value : numbersOf(device, a.exists, moved)) lists.exists.push_back(value != 0);
  if (!factors.empty()) {
    lists.factors = std::move(factors);
    setFactors(lists.factors, a, device);
  }
  if (a.environmentRotation) lists.environmentRotation = numbersOf(device, a.environmentRotation, worlds.count);
  if (a.environmentIntensity)
    for (const double value : numbersOf(device, a.environmentIntensity, worlds.count))
      lists.environmentIntensity.push_back(static_cast<float>(value));
  if (a.environmentIndex)
    lists.environmentIndex =
        environmentIndices(numbersOf(device, a.environmentIndex, worlds.count), worlds.environments.size());
  lists.arrays = {.jointTransforms = a.jointTransforms,
                  .previousJointTransforms = a.previousJointTransforms,
                  .nextJointTransforms = a.nextJointTransforms,
                  .vertices = a.vertices,
                  .previousVertices = a.previousVertices,
                  .nextVertices = a.nextVertices};
  return lists;
}

bool hasFactors(const WorldArrays& a) {
  return a.baseColor || a.metallic || a.roughness || a.emissive;
}

bool hasArrays(const WorldArrays& a) {
  if (hasFactors(a) || hasLights(a) || a.materialChoice) return true;
  if (a.environmentRotation || a.environmentIntensity || a.environmentIndex) return true;
  for (const WorldArray* array : {&a.transforms, &a.previousTransforms, &a.nextTransforms, &a.exists, &a.cameraToWorld,
                                  &a.previousCameraToWorld, &a.nextCameraToWorld, &a.intrinsics})
    if (*array) return true;
  return false;
}

}  // namespace

std::vector<uint32_t> worldsOfStatus(std::span<const uint32_t> status) {
  std::vector<uint32_t> invalid;
  for (uint32_t world = 0; world < status.size(); ++world) {
    const uint32_t bits = status[world];
    if (bits & shared::kWorldWrongTransform)
      badUsage("the transform of an instance must have the last row 0 0 0 1, and one of world {} has another", world);
    if (bits & shared::kWorldWrongJoint) badUsage(kWrongJoint, world);
    if (bits & shared::kWorldWrongPose)
      badUsage(
          "the camera's pose must be a rotation and a translation, without mirror, shear or scale, over 0 0 0 1, and "
          "one in world {} is not",
          world);
    if (bits & shared::kWorldWrongIntrinsics) badUsage(kWrongIntrinsics, world);
    if (bits & shared::kWorldWrongRide)
      badUsage("a camera of world {} rides on an instance whose transform mirrors or has an axis of length 0", world);
    if (bits & shared::kWorldWrongFactors) badUsage(kWrongFactors, world);
    if (bits & shared::kWorldWrongEnvironmentIndex) badUsage(kWrongEnvironmentIndex, world);
    if (bits & shared::kWorldWrongChoice) badUsage(kWrongChoice, world);
    if (bits & shared::kWorldWrongLight)
      badUsage("colors and intensities of lights must be at least 0, and one of world {} is not", world);
    if (bits & shared::kWorldWrongDirection)
      badUsage("the direction of a light must have a length above 0, and one in world {} does not", world);
    if (bits & shared::kWorldWrongEnvironment) badUsage(kWrongEnvironment, world);
    if (bits & shared::kWorldNotFinite) invalid.push_back(world);
  }
  return invalid;
}

void warnOfInvalidWorlds(const std::vector<uint32_t>& invalid, size_t worlds) {
  if (!invalid.empty())
    warn("{} of {} worlds have values that are not finite, and show only the background; the first is world {}",
         invalid.size(), worlds, invalid.front());
}

WorldCameras Scene::Impl::convert(const Worlds& worlds, const render::Settings& settings, render::SceneState& state,
                                  render::Renderer& renderer, vk::Device& device, bool onHost) const {
  WorldConverter converter{worlds, *this, settings, state.worlds};
  converter.listInstances();
  converter.check(device);
  converter.checkDeformations(device);
  render::WorldStates& to = state.worlds;
  std::vector<scene::Camera> each = converter.camerasOfWorld();
  using enum render::Renderer::WorldLights;
  const auto ownLights = !worlds.lightValues.empty() ? InLists : hasLights(worlds.arrays) ? InArrays : OfScene;
  const bool onDevice =
      !onHost && renderer.placesWorlds(settings, each, state.poses, ownLights, !worlds.joints.empty());
  MemoryClaim memory = converter.claim(onDevice);
  const auto convertLists = [&](const Worlds& lists) {
    memory = {};
    to = {.environments = std::move(to.environments)};
    return convert(lists, settings, state, renderer, device, onHost);
  };
  if (hasLights(worlds.arrays) && !(onDevice && converter.placesLights()))
    return convertLists(converter.withLightValues(device));
  if (worlds.arrays.materialChoice && !(onDevice && worlds.factors.empty()))
    return convertLists(converter.withMaterials(device));
  if (onDevice) {
    converter.findInvalid(true);
    converter.listDeformations(renderer, device, true);
    converter.convertMaterials();
    converter.convertLights();
    to.empty = converter.invalid;
    converter.give(renderer, std::move(each));
    return {.cameras = to.inputs->cameras, .invalid = {}, .onDevice = true, .memory = std::move(memory)};
  }
  if (hasArrays(worlds.arrays))
    return convertLists(
        withoutArrays(worlds, device, to.instances.size(),
                      hasFactors(worlds.arrays) ? converter.ownFactors() : std::vector<MaterialFactors>{}));
  converter.findInvalid(false);
  converter.listDeformations(renderer, device, false);
  to.transforms = converter.transformsOf(worlds.transforms);
  to.previous = converter.transformsOf(worlds.previousTransforms);
  to.next = converter.transformsOf(worlds.nextTransforms);
  to.exists = worlds.exists;
  converter.convertMaterials();
  converter.convertLights();
  to.empty = converter.invalid;
  const auto orNow = [](const auto& values, const auto& now) -> const auto& {
    return values.empty() ? now : values;
  };
  const render::Poses& poses = state.poses;
  WorldCameras result{.cameras = {}, .invalid = {}, .memory = std::move(memory)};
  result.cameras = converter.camerasAt(worlds.cameraToWorld, to.transforms, poses.current);
  // Otherwise the cameras do not move.
  if (!worlds.previousCameraToWorld.empty() || !worlds.cameraInstances.empty())
    state.previousCameras = converter.camerasAt(orNow(worlds.previousCameraToWorld, worlds.cameraToWorld),
                                                orNow(to.previous, to.transforms), poses.previous);
  if (!worlds.nextCameraToWorld.empty() || !worlds.cameraInstances.empty())
    state.nextCameras = converter.camerasAt(orNow(worlds.nextCameraToWorld, worlds.cameraToWorld),
                                            orNow(to.next, to.transforms), poses.next);
  for (uint32_t world = 0; world < worlds.count; ++world)
    if (converter.invalid[world]) result.invalid.push_back(world);
  warnOfInvalidWorlds(result.invalid, worlds.count);
  return result;
}

}  // namespace latelight
