// Compute shaders that light a G-buffer. Set 0 is the same for all of them: the bindings of gbuffer_read.glsl, then
// those of lit_maps.glsl.
#pragma once

#include <string>
#include <vector>

#include "render/frame.h"
#include "render/visibility/compute/shown_push.h"

namespace latelight::render {

// The images that gbuffer_read.glsl samples: the layout's targets, depth, and with several samples a pixel their light
// from the geometry pass and the surfaces of pixels.
std::vector<graph::ImageId> gbufferInputs(const Gbuffer& gbuffer);

// A pass over every pixel of every view, in workgroups of 16 by 16, for addCompute(). `file`: the shader's, compiled
// for each layout. `kept`: images whose contents from earlier passes are kept. Its own constants start at
// kFirstOwnConstant, its own bindings after the lit maps.
struct KeptByLighting {
  bool picture = false, counts = false;
};
ComputePass lightingPass(const FrameContext& f, const Gbuffer& gbuffer, const std::string& name,
                         const std::string& file, KeptByLighting kept = {});

// For a pass that reads surfaces by gbuffer_read.glsl: where the layout has no targets, what it finds them by; and what
// it pushes for showSurfaces().
void readSurfaces(const FrameContext& f, ComputePass& pass);
shared::ShownPush shownSurfaces(const FrameContext& f, graph::Context& context);

}  // namespace latelight::render
