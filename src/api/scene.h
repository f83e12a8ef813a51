// The private part of the public API's scene.
#pragma once

#include <latelight/latelight.h>

#include <glm/gtc/constants.hpp>

#include "base/memory.h"
#include "scene/scene.h"
#include "scene/vertices.h"

namespace latelight::render {
class Renderer;
struct SceneState;
struct Settings;
}  // namespace latelight::render
namespace latelight::vk {
class Device;
}

namespace latelight {

inline constexpr const char* kSceneMemory = "the scene";  // for failWithoutMemory()

inline constexpr float kDegreesPerRadian = 180.0f / glm::pi<float>();

// The cameras of all worlds, world by world; if shaders place the worlds, those of each world.
struct WorldCameras {
  std::vector<scene::Camera> cameras;
  std::vector<uint32_t> invalid;  // worlds with values that are not finite
  bool onDevice = false;          // the device reports the other invalid worlds: worldsOfStatus()
  MemoryClaim memory{};           // of the cameras and the converted lists
};

// Returns the invalid worlds, from the status that the device reports. Throws Error(Usage) if values are wrong.
std::vector<uint32_t> worldsOfStatus(std::span<const uint32_t> status);
void warnOfInvalidWorlds(const std::vector<uint32_t>& invalid, size_t worlds);

struct Scene::Impl {
  scene::Scene scene;
  std::vector<Camera> cameras{};
  std::vector<Animation> animations{};
  uint32_t number = nextNumber();  // identifies the scene in its handles

  // The index of an existing element; throws Error(Usage) for any other handle.
  uint32_t index(Handle<Instance> instance) const;
  uint32_t index(Handle<Material> material) const;
  uint32_t index(Handle<Light> light) const;
  uint32_t index(Handle<Mesh> mesh) const;
  uint32_t index(Handle<Texture> texture) const;
  uint32_t index(Handle<Skin> skin) const;

  // The index of the node with this path; throws Error(Usage) if there is none.
  uint32_t nodeAt(const std::string& path) const;

  // Gives a mesh that was made from `from` its skin and morph targets, and poses it at rest. `weightsNode`: as in
  // scene::Deformation. (animation.cpp)
  void addDeformation(const MeshData& from, const scene::VertexSources& sources, int weightsNode,
                      scene::Mesh& mesh) const;

  // The node of the rig with this path. Throws Error(Usage) unless it is a joint of a skin.
  uint32_t jointOf(const std::string& path) const;

  // Returns a camera of `cameras` in another pose, with its own exposure, shutter and readout, which scene::Camera does
  // not have.
  Camera posedCamera(size_t index, const scene::Camera& posed) const;
  Camera posedCamera(const Camera& like, const scene::Camera& posed) const;

  // Adds a camera, `camera` converted, to the scene and to `cameras`, or to neither if memory runs out.
  void addCamera(const Camera& camera, scene::Camera&& converted);

  // Converts worlds for the renderer: returns the cameras, and writes the rest to `state`. `onHost`: as lists, even if
  // shaders can place the worlds.
  struct WorldConverter;
  WorldCameras convert(const Worlds& worlds, const render::Settings& settings, render::SceneState& state,
                       render::Renderer& renderer, vk::Device& device, bool onHost = false) const;

  // Handles of the elements that have not been removed, in the scene's order.
  template <typename Element, typename T>
  std::vector<Handle<Element>> handles(const std::vector<T>& elements,
                                       Handle<Element> (Impl::*handleOf)(uint32_t) const) const {
    std::vector<Handle<Element>> all;
    for (uint32_t i = 0; i < elements.size(); ++i)
      if (!elements[i].removed) all.push_back((this->*handleOf)(i));
    return all;
  }

  Handle<Instance> instance(uint32_t index) const {
    return {number, index, scene.edits.instanceGaps.generation(index)};
  }
  Handle<Material> material(uint32_t index) const {
    return {number, index, scene.edits.materialGaps.generation(index)};
  }
  Handle<Light> light(uint32_t index) const { return {number, index, scene.edits.lightGaps.generation(index)}; }
  Handle<Mesh> mesh(uint32_t index) const { return {number, index, scene.edits.meshGaps.generation(index)}; }
  Handle<Texture> texture(uint32_t index) const { return {number, index, scene.edits.textureGaps.generation(index)}; }
  Handle<Skin> skin(uint32_t index) const { return {number, index, 0}; }

 private:
  static uint32_t nextNumber();
};

// Convert values of the public API to the renderer's. They throw Error(Usage) for invalid values.
glm::dmat4 internalTransform(const Transform& rows, const scene::Scene& scene);
// Returns true for a rotation and a translation of finite numbers, over 0 0 0 1. `tolerance`: of the products of axes.
bool isRigid(const glm::dmat4& pose, double tolerance);
scene::Camera internalCamera(const Camera& camera, const scene::Scene& scene);
// Converts degrees to radians. The limits of a field of view stay usable, although their degrees are rounded to floats.
float verticalFovOf(float degrees);
Camera publicCamera(const scene::Camera& camera, const scene::Scene& scene);
Light publicLight(const scene::Light& from, const scene::Scene& scene);
// `like`: the light before the edit. The light keeps its node if it is not moved. Position and direction are compared
// in the file's frame, so that values that were read and set again do not change.
scene::Light internalLight(const Light& from, const scene::Scene& scene, const scene::Light& like = {});

// Throws Error(Usage) unless there is one radiance per pixel, and twice as many columns as rows.
scene::Environment makeEnvironment(const EnvironmentData& data);

}  // namespace latelight
