#include "render/rays/emitters.h"

namespace latelight::render {

namespace {

bool mayEmit(const shared::Material& material) {
  if (shared::translucent(material.flags)) return false;  // rays pass it
  if (material.flags & shared::kMaterialUnlit) return true;
  return material.emissive.x > 0 || material.emissive.y > 0 || material.emissive.z > 0;
}

}  // namespace

Emitters emittersOf(const scene::Scene& scene, const GpuScene& gpuScene) {
  const GpuInstances& instances = gpuScene.instances();
  Emitters emitters{.triangles = {}, .indices = std::vector(instances.count(), shared::kRayNone)};
  for (uint32_t i = 0; i < instances.count(); ++i) {
    const shared::Instance& instance = instances.record(i);
    if (instances.bounds(i).radius < 0 || !mayEmit(gpuScene.materials().record(instance.material))) continue;
    emitters.indices[i] = static_cast<uint32_t>(emitters.triangles.size());
    const std::vector<uint32_t>& corners = scene.meshes[instance.mesh].indices;
    for (size_t corner = 0; corner + 2 < corners.size(); corner += 3)
      emitters.triangles.push_back({{corners[corner], corners[corner + 1], corners[corner + 2]}, i});
  }
  return emitters;
}

}  // namespace latelight::render
