#include "render/rays/emitters.h"

#include <algorithm>

namespace latelight::render {

namespace {

bool mayEmit(const shared::Material& material) {
  if (shared::translucent(material.flags)) return false;  // rays pass it
  if (material.flags & shared::kMaterialUnlit) return true;
  return material.emissive.x > 0 || material.emissive.y > 0 || material.emissive.z > 0;
}

}  // namespace

std::vector<bool> emittingInstances(const GpuScene& gpuScene) {
  std::vector<bool> emitting;
  for (const shared::Instance& instance : gpuScene.instances().records())
    emitting.push_back(mayEmit(gpuScene.materials().record(instance.material)));
  return emitting;
}

std::vector<bool> emittingInWorlds(const GpuScene& gpuScene) {
  std::vector<bool> emitting = emittingInstances(gpuScene);
  const GpuWorlds& worlds = gpuScene.worlds();
  if (!worlds.hasMaterials()) return emitting;
  const auto emits = [&](uint32_t material) { return mayEmit(gpuScene.materials().record(material)); };
  for (size_t i = 0; i < worlds.records().size(); ++i)
    if (emits(worlds.records()[i].material)) emitting[i % emitting.size()] = true;
  if (!worlds.onDevice()) return emitting;
  const bool any = worlds.emissiveOnDevice() || std::ranges::any_of(worlds.chosenMaterials(), emits);
  for (const uint32_t instance : worlds.listed())
    if (any) emitting[instance] = true;
  return emitting;
}

Emitters emittersOf(const scene::Scene& scene, const GpuScene& gpuScene, const std::vector<bool>& emitting) {
  const GpuInstances& instances = gpuScene.instances();
  Emitters emitters{.triangles = {}, .indices = std::vector(instances.count(), shared::kRayNone)};
  for (uint32_t i = 0; i < instances.count(); ++i) {
    const shared::Instance& instance = instances.record(i);
    if (instances.bounds(i).radius < 0 || !emitting[i]) continue;
    emitters.indices[i] = static_cast<uint32_t>(emitters.triangles.size());
    const std::vector<uint32_t>& corners = scene.meshes[instance.mesh].indices;
    for (size_t corner = 0; corner + 2 < corners.size(); corner += 3)
      emitters.triangles.push_back({{corners[corner], corners[corner + 1], corners[corner + 2]}, i});
  }
  return emitters;
}

}  // namespace latelight::render
