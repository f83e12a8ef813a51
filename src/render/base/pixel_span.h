// Spans of pixels for shaders with one pixel per invocation: a workgroup processes several blocks of pixels, one after
// the other (glsl/pixel_span.glsl). The next block needs no other constants, finds what the previous ones have loaded
// in the caches, and starts when a subgroup is ready instead of when all registers of a workgroup are free. But
// workgroups that take longer leave more of a GPU without work at the end of a pass.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "render/base/pass.h"

namespace latelight::render {

// Returns the blocks along each side of a span: 1 or kSpanSide. `pixels`: the pixels and layers of the pass.
constexpr uint32_t kSpanSide = 4;
uint32_t spanSide(const vk::Device& device, const glm::uvec3& pixels);

// Dispatches a pass of blocks of pixels in spans.
void useSpans(ComputePass& pass, uint32_t side);

}  // namespace latelight::render
