// Helpers for compute shaders that light a G-buffer. Descriptor set 0 is the same for all of them: the bindings of
// gbuffer_read.glsl, then those of lit_maps.glsl.
#pragma once

#include <string>
#include <vector>

#include "render/frame/frame.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

// The images that gbuffer_read.glsl samples: the layout's targets, depth, and, with several samples per pixel, the
// light from the geometry pass and the surfaces of pixels.
std::vector<graph::ImageId> gbufferInputs(const Gbuffer& gbuffer);

// A pass over every pixel of every view, in workgroups of kPixelGroupX by kPixelGroupY pixels, for addCompute(). `file`
// is the shader's file, compiled for each layout. `kept` names the images whose contents from earlier passes are
// preserved. The pass's own bindings start after the lit maps.
struct PreservedByLighting {
  bool picture = false, counts = false;
};
ComputePass lightingPass(const FrameContext& f, const Gbuffer& gbuffer, const std::string& name,
                         const std::string& file, PreservedByLighting kept = {});

// For a pass that reads surfaces through gbuffer_read.glsl. With a layout without targets it declares the visibility
// buffer and the resources that shaders need to evaluate surfaces; surfacePush() then returns the push constants for
// bindSurfaces(). With other layouts it adds nothing.
void readSurfaces(const FrameContext& f, const Gbuffer& gbuffer, ComputePass& pass);

}  // namespace latelight::render
