// Worlds of the public API: selects how they are converted.
#include <algorithm>

#include "api/worlds/converter.h"
#include "api/worlds/world_array.h"

namespace latelight {

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

WorldCameras Scene::Impl::convert(const Worlds& worlds, const render::Settings& settings, render::SceneState& state,
                                  render::Renderer& renderer, vk::Device& device, bool onHost) const {
  WorldConverter converter{worlds, *this, settings, renderer, device, state.worlds};
  converter.listInstances();
  converter.check();
  converter.checkDeformations();
  render::WorldStates& to = state.worlds;
  std::vector<scene::Camera> cameras = converter.camerasOfWorld();
  using enum render::Renderer::WorldLights;
  const auto ownLights = !worlds.lightValues.empty() ? InLists : hasLights(worlds.arrays) ? InArrays : OfScene;
  const bool onDevice =
      !onHost && renderer.placesWorlds(settings, cameras, state.poses, ownLights, !worlds.joints.empty());
  MemoryClaim memory = converter.claim(onDevice);
  const auto convertLists = [&](const Worlds& lists) {
    memory = {};
    to = {.environments = std::move(to.environments)};
    return convert(lists, settings, state, renderer, device, onHost);
  };
  if (hasLights(worlds.arrays) && !(onDevice && converter.placesLights()))
    return convertLists(converter.withLightValues());
  if (worlds.arrays.materialChoice && !(onDevice && worlds.factors.empty()))
    return convertLists(converter.withMaterials());
  if (!onDevice && converter.hasArrays()) return convertLists(converter.withoutArrays());
  converter.findInvalid(onDevice);
  converter.listDeformations(onDevice);
  WorldCameras result = onDevice ? converter.convertOnDevice(std::move(cameras)) : converter.convertOnHost(state);
  result.memory = std::move(memory);
  return result;
}

}  // namespace latelight
