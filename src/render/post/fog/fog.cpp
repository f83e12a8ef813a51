#include "render/post/fog/fog.h"

#include "render/post/fog/fog_push.h"

namespace latelight::render {

void addFog(const FrameContext& f, const Gbuffer& gbuffer) {
  addCompute(
      f,
      {.stage = graph::Stage::Post,
       .name = "fog",
       .shader = "fog.comp",
       .bindings = Bindings(f.device).sampled(gbuffer.depth).storage(gbuffer.light, graph::Use::StorageReadWrite),
       .size = f.pixels(),
       .constants = f.setup.constants(),
       .fullImage = true},
      shared::FogPush{f.constants});
}

void addFogOfUncovered(const FrameContext& f, const Gbuffer& gbuffer) {
  addCompute(f,
             {.stage = graph::Stage::Post,
              .name = "fog",
              .shader = "fog_uncovered.comp",
              .bindings = Bindings(f.device).storage(gbuffer.light, graph::Use::StorageReadWrite),
              .size = f.pixels(),
              .fullImage = true},
             shared::FogPush{f.constants});
}

}  // namespace latelight::render
