// The maps that every lit shader binds (glsl/lit_maps.glsl): the environment's, the shadow atlas, and ambient
// occlusion. A pass that lights appends their bindings to its pipeline, declares them, and binds them; whatever they
// are, it needs no other edit.
#pragma once

#include <vector>

#include "render/frame.h"
#include "vk/commands.h"

namespace latelight::render {

inline constexpr size_t kLitMaps = GpuEnvironment::kBindings + 2;

void appendLitBindings(std::vector<vk::Binding>& bindings);
// `use`: SampledFragment or SampledCompute.
void appendLitAccesses(std::vector<graph::Access>& accesses, const Gbuffer& gbuffer, graph::Use use);
void appendLitImages(std::vector<vk::BoundImage>& images, graph::Context& context, const FrameInputs& inputs,
                     const Gbuffer& gbuffer);

}  // namespace latelight::render
