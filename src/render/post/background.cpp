#include "render/post/background.h"

#include "render/post/background_push.h"

namespace latelight::render {

// Images of environments differ in size, so each has a pass of its own.
void addBackground(const FrameContext& f, const Gbuffer& gbuffer) {
  for (uint32_t environment = 0; environment < f.environment.count(); ++environment)
    addCompute(f,
               {.stage = graph::Stage::Post,
                .name = "background",
                .shader = "background.comp",
                .bindings = Bindings(f.device)
                                .storage(gbuffer.light, graph::Use::StorageReadWrite)
                                .outside(f.environment.radiance(environment)),
                .size = f.pixels(),
                .constants = f.setup.constants()},
               shared::BackgroundPush{f.constants, environment, 0});
}

}  // namespace latelight::render
