#include "render/post/background.h"

#include "render/post/background_push.h"

namespace latelight::render {

void addBackground(const FrameContext& f, const Gbuffer& gbuffer) {
  addCompute(
      f,
      {.stage = graph::Stage::Post,
       .name = "background",
       .shader = "background.comp",
       .bindings =
           Bindings(f.device).storage(gbuffer.light, graph::Use::StorageReadWrite).outside(f.environment.radiance()),
       .size = f.pixels(),
       .constants = f.setup.constants()},
      shared::BackgroundPush{f.constants});
}

}  // namespace latelight::render
