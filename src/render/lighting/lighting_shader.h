// Compute shaders that light a G-buffer. Set 0 is the same for all of them: what gbuffer_read.glsl has, then what
// lit_maps.glsl has.
#pragma once

#include <string>
#include <vector>

#include "render/frame.h"

namespace latelight::render {

// What gbuffer_read.glsl samples: the layout's targets, depth, and with several samples a pixel the light they had and
// the surfaces of pixels.
std::vector<graph::ImageId> gbufferInputs(const Gbuffer& gbuffer);

// A pass over every pixel of every view, in workgroups of 16 by 16, for addCompute(). `file`: the shader's, compiled
// for each layout. `kept`: what earlier passes have left there. Constants of its own start at kFirstOwnConstant,
// bindings of its own behind the lit maps'.
struct KeptByLighting {
  bool picture = false, counts = false;
};
ComputePass lightingPass(const FrameContext& f, const Gbuffer& gbuffer, const std::string& name,
                         const std::string& file, KeptByLighting kept = {});

}  // namespace latelight::render
