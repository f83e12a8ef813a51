// Blended surfaces (glTF's alphaMode BLEND), drawn after all others are lit: by the same material, BRDF and lights.
// docs/transparency.md says how the methods differ.
#pragma once

#include <string>
#include <vector>

#include "render/frame.h"
#include "render/visibility/draw.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

// FrameSetup::transparency.method, numbered as in TransparencyMethod.
inline constexpr uint32_t kTransparencyExact = 0, kTransparencySorted = 1, kTransparencyWeighted = 2,
                          kTransparencyNone = 3;

// Adds the passes that blend surfaces over the lit picture in gbuffer.light, premultiplied by alpha; none where no view
// has any.
void addTransparency(const FrameContext& f, Gbuffer gbuffer);

// exact, and every method where nothing is drawn by the graphics pipeline.
void addFragmentLists(const FrameContext& f, const Gbuffer& gbuffer);
void addSortedTransparency(const FrameContext& f, const Gbuffer& gbuffer);
void addWeightedTransparency(const FrameContext& f, const Gbuffer& gbuffer);

// Whether blended or transmissive surfaces may have layers: then shaders of the variant "coated" light them.
bool blendedHaveLayers(const FrameContext& f);
// The lit maps, and for those shaders what lies behind: set 0 of all that light blended fragments.
Bindings blendedMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::Use use);

// Fragment buffers by their addresses: those that the running pass declares.
shared::FragmentLists listsOf(graph::Context& context, const FragmentBuffers& buffers);

// Samples per pixel at which fragments are stored: the frame's with the raster compute, and where drawn fragments can
// read their coverage after the depth test, else 1.
uint32_t fragmentSamples(const vk::Device& device, const FrameSetup& setup);

// Pipelines that draw blended fragments (blended.glsl): depth is tested, not written. A surface exactly on an opaque
// one, such as a decal, is visible. blendedMaps() are set 0.
struct BlendedTarget {
  std::string vertex, fragment;  // shaders; no vertex shader: the usual one
  uint32_t pushBytes = sizeof(shared::DrawPush);
  std::vector<VkFormat> colors{};
  vk::Blend blend = vk::Blend::Replace;
  uint32_t samples = 1;  // those of the frame, or 1, with resolved depth
};
ScenePipelines blendedPipelines(const FrameContext& f, const Bindings& maps, const BlendedTarget& target);

}  // namespace latelight::render
