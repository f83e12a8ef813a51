#include "render/lighting/reference/indirect_filter.h"

#include "render/lighting/reference/indirect_filter_push.h"
#include "render/visibility/visibility.h"

namespace latelight::render {

namespace {

constexpr VkFormat kSignalFormat = VK_FORMAT_R32G32B32A32_SFLOAT;
constexpr int kSteps[] = {1, 2, 4, 8, 16};  // of the wavelets

shared::IndirectFilterPush pushOf(const FrameContext& f, int step, uint32_t frames = 0) {
  return {.frame = f.constants, .step = step, .samples = f.setup.paths, .frames = frames, .padding = 0};
}

// Returns a pass from the signals to the next ones, with the bindings of indirect_filter.glsl.
ComputePass filterPass(const FrameContext& f, const IndirectSignals& signals, const IndirectSignals& next,
                       const char* shader) {
  return {.stage = graph::Stage::Lighting,
          .name = "filter of indirect light",
          .shader = shader,
          .bindings = Bindings(f.device)
                          .sampled({signals.scattered, signals.mirrored, signals.guide, signals.scatteredAlbedo})
                          .storage(next.scattered, graph::Use::StorageWrite)
                          .storage(next.mirrored, graph::Use::StorageWrite),
          .size = f.pixels()};
}

IndirectSignals withNewSignals(const FrameContext& f, const IndirectSignals& signals) {
  IndirectSignals next = signals;
  next.scattered = createTarget(f, kSignalFormat, "filtered light");
  next.mirrored = createTarget(f, kSignalFormat, "filtered mirrored light");
  return next;
}

IndirectSignals addWavelet(const FrameContext& f, const IndirectSignals& signals, int step) {
  const IndirectSignals next = withNewSignals(f, signals);
  addCompute(f, filterPass(f, signals, next, "indirect_wavelet.comp"), pushOf(f, step));
  return next;
}

// `surfaces`: those of the history, or null.
IndirectSignals addVariance(const FrameContext& f, const IndirectSignals& signals, graph::ImageId surfaces) {
  const IndirectSignals next = withNewSignals(f, signals);
  ComputePass pass = filterPass(f, signals, next, "indirect_variance.comp");
  pass.bindings.sampled(surfaces ? surfaces : signals.guide);  // the binding requires an image
  pass.constants = {{kHistoryConstant, surfaces ? 1u : 0u}};
  addCompute(f, std::move(pass), pushOf(f, 1));
  return next;
}

// Returns the signals as means over the frames of the history.
IndirectSignals addHistory(const FrameContext& f, const IndirectSignals& signals, const FrameHistory::Images& history,
                           graph::ImageId motion) {
  const bool begins = history.last.empty();
  IndirectSignals next = signals;
  next.scattered = history.next[0];
  next.mirrored = history.next[1];
  ComputePass pass = filterPass(f, signals, next, "indirect_temporal.comp");
  pass.bindings.sampled(motion);
  if (begins)  // the bindings require images, which the shader does not read
    pass.bindings.sampled({signals.scattered, signals.mirrored, signals.guide});
  else
    pass.bindings.sampled(history.last);
  pass.bindings.storage(history.next[2], graph::Use::StorageWrite);
  addCompute(f, std::move(pass), pushOf(f, 0, begins ? 0 : 1));
  return next;
}

}  // namespace

FrameHistory indirectHistory() {
  return FrameHistory({{kSignalFormat, "history of light"},
                       {kSignalFormat, "history of mirrored light"},
                       {VK_FORMAT_R32G32B32A32_UINT, "surfaces of the history"}});
}

void addIndirectFilter(const FrameContext& f, const IndirectSignals& signals, const VisibilityBuffer& visible,
                       graph::ImageId light) {
  IndirectSignals filtered = signals;
  graph::ImageId surfaces;
  if (f.indirectHistory) {
    const graph::ImageId motion = addMotion(f, visible, MotionUse::Surfaces);
    const FrameHistory::Images history = f.indirectHistory->advance(f);
    filtered = addHistory(f, signals, history, motion);
    surfaces = history.next[2];
  }
  filtered = addVariance(f, filtered, surfaces);
  for (const int step : kSteps) filtered = addWavelet(f, filtered, step);
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
