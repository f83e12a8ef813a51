// Arrays for the shaders that place worlds and deform meshes.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "api/device_array.h"
#include "api/worlds/converter.h"
#include "api/worlds/world_array.h"
#include "base/parallel.h"

namespace latelight {

namespace {

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

}  // namespace

// Returns true if shaders may convert the arrays of lights. The host turns the shapes of area lights.
bool Scene::Impl::WorldConverter::placesLights() const {
  const auto isArea = [&](const Handle<Light>& light) {
    return shared::lightIsArea(scene.scene.lights[scene.index(light)].type);
  };
  if (from.arrays.lightDirection && std::ranges::any_of(from.lights, isArea)) return false;
  return scene.scene.lights.size() + settings.sun.has_value() <= shared::kMaxPlacedLights;
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

// Gives the arrays of joints and vertices to the shaders that deform meshes. If the host places the worlds, it has
// their numbers, too, for the bounds.
void Scene::Impl::WorldConverter::listDeformations(bool onDevice) {
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
    if (!onDevice) checkNumbers(*ofJoints[time], *ofVertices[time], time == 0);
  }
  writer.write(renderer, given.memory);
}

// Gives the arrays, or the lists as arrays, to the shaders that place the worlds.
void Scene::Impl::WorldConverter::give(std::vector<scene::Camera> cameras) const {
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

WorldCameras Scene::Impl::WorldConverter::convertOnDevice(std::vector<scene::Camera> cameras) {
  convertMaterials();
  convertLights();
  to.empty = invalid;
  give(std::move(cameras));
  return {.cameras = to.inputs->cameras, .invalid = {}, .onDevice = true};
}

}  // namespace latelight
