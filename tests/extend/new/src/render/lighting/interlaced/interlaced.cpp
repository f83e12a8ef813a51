// interlaced: an example of a lighting technique. It shades the even rows first, then the odd rows, like interlaced
// video. Each pass requires half the time, so a device that aborts long dispatches can shade twice as many lights.
#include "render/lighting/interlaced/interlaced_push.h"
#include "render/lighting/lighting_shader.h"
#include "render/lighting/technique.h"

namespace latelight::render {

namespace {

LightLists add(const FrameContext& f, const Gbuffer& gbuffer) {
  for (const uint32_t row : {0u, 1u}) {
    ComputePass field =
        lightingPass(f, gbuffer, "lighting interlaced", "interlaced.comp", {.picture = row > 0, .counts = row > 0});
    field.size.y = (f.height + 1 - row) / 2;
    if (field.size.y == 0) continue;
    addCompute(f, std::move(field), [row, frame = f.constants, visible = gbuffer.visible](graph::Context& context) {
      return shared::FieldPush{.frame = frame, .shown = surfacePush(visible, context), .firstRow = row};
    });
  }
  return {};
}

}  // namespace

TechniqueInfo technique_interlaced() {
  return {.description = "the even rows of the picture, then the odd ones; every light at every pixel", .add = add};
}

}  // namespace latelight::render
