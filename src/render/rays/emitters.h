// Emissive triangles, which paths sample in proportion to their power.
#pragma once

#include <vector>

#include "render/gpu_scene/gpu_scene.h"
#include "shared/rays.h"

namespace latelight::render {

struct Emitters {
  std::vector<shared::RayEmitter> triangles;
  std::vector<uint32_t> indices;  // RayScene::emitterIndices
};

// Returns which instances may emit light that rays find: by their materials in the scene, or in any world.
std::vector<bool> emittingInstances(const GpuScene& gpuScene);
std::vector<bool> emittingInWorlds(const GpuScene& gpuScene);

// Returns the triangles of the visible instances among these.
Emitters emittersOf(const scene::Scene& scene, const GpuScene& gpuScene, const std::vector<bool>& emitting);

}  // namespace latelight::render
