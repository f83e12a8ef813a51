// forward: the scene is drawn once more after the depth pass, and each fragment loops over all lights.
#pragma once

#include "render/frame.h"

namespace latelight::render {

// How a fragment goes through the lights: dealt to the lanes of its subgroup, as compute shaders do, or each loaded by
// every fragment: the plain reference, and the way of devices without subgroups in fragment shaders.
enum class ForwardLoop : uint32_t { Dealt, Plain };
ForwardLoop forwardLoop(vk::Device& device);  // the better one that it can

void addForward(const FrameContext& f, const Gbuffer& gbuffer, ForwardLoop loop);

}  // namespace latelight::render
