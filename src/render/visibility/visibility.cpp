#include "render/visibility/visibility.h"

#include "render/visibility/compute/raster_chain.h"

namespace latelight::render {

void readVisibleSurfaces(const FrameContext& f, const VisibilityBuffer& visible, ComputePass& pass) {
  bindTextures(f, pass);
  pass.buffers.emplace_back(visible.ids, graph::Use::StorageRead);
}

shared::ShownPush shownSurfaces(const VisibilityBuffer& visible, graph::Context& context) {
  if (!visible.ids || !context.declares(visible.ids)) return {};
  return {visible.instances, context.buffer(visible.ids).address()};
}

}  // namespace latelight::render
