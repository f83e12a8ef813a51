// Converts the worlds of one call of the public API to the renderer's.
//
//   check.cpp      checks lists and arrays, claims memory, and finds worlds with values that are not finite
//   lists.cpp      reads arrays, for worlds that the host places
//   on_host.cpp    converts lists: transforms, materials, lights and the cameras of all worlds
//   on_device.cpp  gives the arrays, or the lists as arrays, to the shaders that place worlds and deform meshes
//   convert.cpp    selects between these
#pragma once

#include <latelight/latelight.h>

#include <array>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "api/scene.h"
#include "base/error.h"
#include "base/memory.h"
#include "render/settings/settings.h"
#include "render/submit/renderer.h"
#include "render/submit/scene_state.h"
#include "vk/device.h"

namespace latelight {

// The arrays of the same element that worlds describe.
bool hasLights(const WorldArrays& arrays);
bool hasFactors(const WorldArrays& arrays);

// Converts one call's worlds.
struct Scene::Impl::WorldConverter {
  const Worlds& from;
  const Impl& scene;
  const render::Settings& settings;
  render::Renderer& renderer;
  vk::Device& device;
  render::WorldStates& to;
  std::vector<uint32_t> placeOf{};  // index in `instances` per instance of the scene; ~0u: not listed
  std::vector<uint8_t> invalid{};   // per world

  void listInstances();
  size_t vertexCount() const;
  bool hasIntrinsics() const { return from.arrays.intrinsics || !from.intrinsics.empty(); }

  void check() const;
  void checkArrays() const;
  void checkDeformations() const;
  void checkEnvironmentIndex(double index, size_t world) const;
  void checkNumbers(const WorldArray& joints, const WorldArray& vertices, bool keep);
  MemoryClaim claim(bool onDevice) const;
  void findInvalid(bool onDevice);

  bool hasArrays() const;  // except those of joints and vertices, which shaders read in any case
  Worlds withLightValues() const;
  Worlds withMaterials() const;
  Worlds withoutArrays() const;
  std::vector<MaterialFactors> ownFactors() const;

  void convertMaterials() const;
  void convertLights() const;
  std::vector<glm::dmat4> transformsOf(const std::vector<Transform>& values) const;
  glm::dmat4 frameOf(uint32_t instance, uint32_t world, const std::vector<glm::dmat4>& transforms,
                     const std::vector<glm::dmat4>& scenes) const;
  Lens lensWith(const Camera& camera, const std::array<double, 4>& intrinsics) const;
  std::vector<scene::Camera> camerasAt(const std::vector<Transform>& poses, const std::vector<glm::dmat4>& transforms,
                                       const scene::Pose& pose) const;
  WorldCameras convertOnHost(render::SceneState& state);

  bool placesLights() const;
  std::vector<scene::Camera> camerasOfWorld() const;
  void listDeformations(bool onDevice);
  void give(std::vector<scene::Camera> cameras) const;
  WorldCameras convertOnDevice(std::vector<scene::Camera> cameras);
};

}  // namespace latelight
