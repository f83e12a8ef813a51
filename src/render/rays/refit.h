// Refits the boxes of a mesh's BVH to its vertices on the device (ray_refit.comp).
#pragma once

#include "graph/graph.h"
#include "render/rays/refit_push.h"
#include "vk/object_cache.h"

namespace latelight::render {

vk::PipelineRef refitPipeline(vk::Device& device);

// Records the refit of one mesh, or of the meshes of `worlds` worlds, whose nodes follow each other.
void recordRefit(graph::Context& context, const vk::PipelineRef& pipeline, shared::RayRefitPush push,
                 uint32_t worlds = 1);

}  // namespace latelight::render
