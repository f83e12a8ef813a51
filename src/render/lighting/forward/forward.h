// forward: the scene is drawn once more after the depth pass, and each fragment loops over all lights.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// How a fragment loops over lights: distributed over the lanes of its subgroup, as in compute shaders, or each loaded
// by every fragment: the plain reference, and the path for devices without subgroups in fragment shaders.
enum class ForwardLoop : uint32_t { Dealt, Plain };
ForwardLoop forwardLoop(vk::Device& device);  // the better one that the device supports

void addForward(const FrameContext& f, const Gbuffer& gbuffer, ForwardLoop loop);

}  // namespace latelight::render
