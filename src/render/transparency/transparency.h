// Blended surfaces (glTF's alphaMode BLEND), drawn after all others are lit: by the same material, BRDF and lights.
// docs/transparency.md says how the methods differ.
#pragma once

#include <memory>

#include "render/frame.h"

namespace latelight::render {

// FrameSetup::transparency.method, in the order of transparencies() in settings.h.
inline constexpr uint32_t kTransparencyExact = 0, kTransparencySorted = 1, kTransparencyWeighted = 2,
                          kTransparencyNone = 3;

class Transparency {
 public:
  virtual ~Transparency() = default;
  // Adds the passes that lay blended surfaces over the lit picture in gbuffer.light, premultiplied by alpha; none where
  // no view has any.
  virtual void add(graph::Graph& graph, const FrameInputs& inputs, const Gbuffer& gbuffer) = 0;
  // As Frame::outgrown().
  virtual bool outgrown(const graph::Executor&) { return false; }
};

// Null where the scene has no blended material, or they are to be left out.
std::unique_ptr<Transparency> makeTransparency(vk::Device& device, const GpuScene& scene, const FrameSetup& setup);

}  // namespace latelight::render
