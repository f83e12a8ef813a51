#include "render/visibility/rays/trace_visible.h"

#include "render/base/pixel_span.h"
#include "render/visibility/compute/raster_chain.h"
#include "render/visibility/rays/trace_push.h"
#include "shared/rays.h"

namespace latelight::render {

VisibilityBuffer addTracedSurfaces(const FrameContext& f, const RasterInstances& rasterInstances,
                                   const RasterInstances::Share& share, bool blendedToo) {
  const glm::uvec3 size = f.pixels();
  const VisibilityBuffer visible{
      .ids = f.graph.create(vk::BufferDesc{.size = uint64_t{8} * size.x * size.y * size.z * f.setup.samples,
                                           .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                           .name = "visible"}),
      .instances = rasterInstances.address()};
  ComputePass pass{.stage = graph::Stage::Visibility,
                   .name = "trace",
                   .shader = "trace_visible.comp",
                   .bindings = Bindings(f.device),
                   .size = size,
                   .constants = {{kSamplesConstant, f.setup.samples},
                                 {kLensConstant, f.lens ? 1u : 0u},
                                 {kAlphaTestConstant, share.anyMasked ? 1u : 0u}},
                   .buffers = {{visible.ids, graph::Use::StorageWrite}}};
  useSpans(pass, spanSide(f.device, size));
  addVastConstant(f, pass);
  addCompute(f, std::move(pass),
             [ids = visible.ids, frame = f.constants, firstTriangles = rasterInstances.firstTriangles(),
              surfaces = blendedToo ? shared::kRayAnySurface : 0](graph::Context& context) {
               return shared::TraceVisiblePush{.frame = frame,
                                               .firstTriangles = firstTriangles,
                                               .visible = context.buffer(ids).address(),
                                               .surfaces = surfaces,
                                               .padding = 0};
             });
  return visible;
}

}  // namespace latelight::render
