// Forward shading: the scene is drawn again after the depth pass, and each fragment loops over all lights.
#pragma once

#include "render/frame/frame.h"

namespace latelight::render {

// How a fragment loops over lights. Dealt: the lanes of a subgroup each load some lights and share them, as in compute
// shaders. Plain: every fragment loads every light; this is the reference, and the path for devices that do not support
// subgroup operations in fragment shaders.
enum class ForwardLoop : uint32_t { Redistributed, Plain };
ForwardLoop forwardLoop(vk::Device& device);  // Dealt if the device supports it

// Adds the pass that writes the lit picture to gbuffer.light. Requires the raster hardware.
LightLists addForward(const FrameContext& f, const Gbuffer& gbuffer, ForwardLoop loop);

}  // namespace latelight::render
