#include "render/lighting/reference/indirect_filter.h"

#include "render/lighting/reference/indirect_filter_push.h"

namespace latelight::render {

namespace {

constexpr VkFormat kSignalFormat = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr int kSteps[] = {1, 2, 4, 8, 16};  // of the wavelets

shared::IndirectFilterPush pushOf(const FrameContext& f, int step) {
  return {.frame = f.constants, .step = step, .padding = 0};
}

IndirectSignals withNewSignals(const FrameContext& f, const IndirectSignals& signals) {
  IndirectSignals next = signals;
  next.scattered = createTarget(f, kSignalFormat, "filtered light");
  next.mirrored = createTarget(f, kSignalFormat, "filtered mirrored light");
  return next;
}

IndirectSignals addStep(const FrameContext& f, const IndirectSignals& signals, const char* shader, int step) {
  const IndirectSignals next = withNewSignals(f, signals);
  addCompute(f,
             {.stage = graph::Stage::Lighting,
              .name = "filter of indirect light",
              .shader = shader,
              .bindings = Bindings(f.device)
                              .sampled({signals.scattered, signals.mirrored, signals.guide, signals.scatteredAlbedo})
                              .storage(next.scattered, graph::Use::StorageWrite)
                              .storage(next.mirrored, graph::Use::StorageWrite),
              .size = f.pixels()},
             pushOf(f, step));
  return next;
}

}  // namespace

void addIndirectFilter(const FrameContext& f, const IndirectSignals& signals, graph::ImageId light) {
  IndirectSignals filtered = addStep(f, signals, "indirect_variance.comp", 1);
  for (const int step : kSteps) filtered = addStep(f, filtered, "indirect_wavelet.comp", step);
  addCompute(f,
             {.stage = graph::Stage::Lighting,
              .name = "filtered indirect light",
              .shader = "indirect_sum.comp",
              .bindings = Bindings(f.device)
                              .sampled({filtered.scattered, filtered.mirrored, filtered.scatteredAlbedo,
                                        filtered.mirroredAlbedo})
                              .storage(light, graph::Use::StorageReadWrite),
              .size = f.pixels()},
             pushOf(f, 0));
}

}  // namespace latelight::render
