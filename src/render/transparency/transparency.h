// Transparency: blended surfaces (glTF's alphaMode BLEND) are rendered after all others are lit, with the same
// materials, BRDF and lights. docs/transparency.md compares the methods: per-pixel lists (exact), sorted, and weighted
// blended OIT.
#pragma once

#include <string>
#include <vector>

#include "render/frame/frame.h"
#include "render/visibility/draw.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

// FrameConfig::transparency.method, numbered as in TransparencyMethod.
inline constexpr uint32_t kTransparencyExact = 0, kTransparencySorted = 1, kTransparencyWeighted = 2,
                          kTransparencyNone = 3;

// Adds the passes that blend surfaces over the lit picture in gbuffer.light, premultiplied by alpha. Adds none if no
// view has blended surfaces.
void addTransparency(const FrameContext& f, Gbuffer gbuffer);

// Per-pixel lists: the method exact, and every method if the raster is compute.
void addFragmentLists(const FrameContext& f, const Gbuffer& gbuffer);
void addSortedTransparency(const FrameContext& f, const Gbuffer& gbuffer);
void addWeightedTransparency(const FrameContext& f, const Gbuffer& gbuffer);

// Returns true if blended or transmissive surfaces may have coats. Shaders of the variant "coated" then light them.
bool blendedHaveLayers(const FrameContext& f);
// The lit maps and, for coated shaders, the transmission background: set 0 of all shaders that light blended fragments.
Bindings blendedMaps(const FrameContext& f, const Gbuffer& gbuffer, graph::Use use);

// The addresses of the fragment buffers; 0 for buffers that the running pass does not declare.
shared::FragmentLists listsOf(graph::Context& context, const FragmentBuffers& buffers);

// The number of samples per pixel at which fragments are stored: that of the frame if the raster is compute or if
// fragment shaders can read their coverage after the depth test, else 1.
uint32_t fragmentSamples(const vk::Device& device, const FrameConfig& setup);

// Pipelines that draw blended fragments (blended.glsl). Depth is tested but not written. A surface at exactly the depth
// of an opaque one, such as a decal, is visible. Set 0 is blendedMaps().
struct BlendedTarget {
  std::string vertex;  // default: scene.vert
  vk::ShaderKey fragment;
  uint32_t pushBytes = sizeof(shared::DrawPush);
  std::vector<VkFormat> colors{};
  vk::Blend blend = vk::Blend::Replace;
  uint32_t samples = 1;  // per pixel: the frame's, or 1 with resolved depth
};
ScenePipelines blendedPipelines(const FrameContext& f, const Bindings& maps, const BlendedTarget& target);

}  // namespace latelight::render
