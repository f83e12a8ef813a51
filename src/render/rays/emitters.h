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

// Returns the triangles of visible instances that rays hit and whose material may emit light.
Emitters emittersOf(const scene::Scene& scene, const GpuScene& gpuScene);

}  // namespace latelight::render
