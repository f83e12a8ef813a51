// Meters views for the automatic exposure. Each view is rendered for its linear color, small and without the sensor and
// the effects that follow exposure. Its picture is then the same as with the exposure that was found, given as a
// number: whole or in strips, alone or with other views.
#include "render/submit/metering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "render/frame/view.h"
#include "render/sensor/sensor.h"
#include "render/submit/job.h"
#include "render/submit/renderer.h"
#include "shared/color.h"

namespace latelight::render {

namespace {

constexpr uint32_t kMaxSide = 512;  // pixels
constexpr int kMinLog = -32, kMaxLog = 32, kBinsPerStop = 16;
constexpr double kUnitsPerStop = 65536;  // of the logarithms in a bin's sum

// Colors are halves, so a view is metered again at the exposure that was found if it differs by more than this from the
// one that it was rendered with.
constexpr double kPreciseStops = 8;
constexpr double kDarkStops = 20;  // added if all covered pixels are black
constexpr int kMaxRounds = 4;

struct Bin {
  int64_t count = 0, sum = 0;  // of logarithms, in units
};
using Histogram = std::array<Bin, (kMaxLog - kMinLog) * kBinsPerStop>;

Histogram histogramOf(const output::AovImage& color, int64_t& total) {
  Histogram bins{};
  total = 0;
  for (size_t i = 0; i + 3 < color.values.size(); i += 4) {
    const float* c = &color.values[i];
    const double y = double{shared::luminance({c[0], c[1], c[2]})} / double{c[3]};
    if (!(c[3] > 0) || !(y > 0) || !std::isfinite(y)) continue;
    const double stops = std::clamp(std::log2(y), double{kMinLog}, kMaxLog - 1e-6);
    Bin& bin = bins[static_cast<size_t>((stops - kMinLog) * kBinsPerStop)];
    ++bin.count, ++total;
    bin.sum += std::llround(stops * kUnitsPerStop);
  }
  return bins;
}

bool covers(const output::AovImage& color) {
  for (size_t i = 3; i < color.values.size(); i += 4)
    if (color.values[i] > 0) return true;
  return false;
}

float factorOf(double ev) {
  return static_cast<float>(std::exp2(std::clamp(ev, -double{kMaxExposure}, double{kMaxExposure})));
}

}  // namespace

std::optional<double> meanLogLuminance(const output::AovImage& color) {
  int64_t total = 0;
  const Histogram bins = histogramOf(color, total);
  if (total == 0) return std::nullopt;
  const auto tail = static_cast<int64_t>(kMeteredTail * static_cast<double>(total));
  const int64_t first = tail, end = total - tail;
  int64_t before = 0;
  double sum = 0;
  for (const Bin& bin : bins) {
    const int64_t counted = std::min(end, before + bin.count) - std::max(first, before);
    if (counted > 0)
      sum += static_cast<double>(bin.sum) / static_cast<double>(bin.count) * static_cast<double>(counted);
    before += bin.count;
  }
  return sum / static_cast<double>(end - first) / kUnitsPerStop;
}

Settings meteringSettings(const Settings& settings, bool hasLens) {
  Settings metering = idealSensorSettings(settings);  // a sensor clips and rounds bright and dark light
  const uint32_t reduction = hasLens ? 1 : (std::max(settings.width, settings.height) + kMaxSide - 1) / kMaxSide;
  metering.width = std::max(1u, settings.width / reduction);
  metering.height = std::max(1u, settings.height / reduction);
  metering.exposure = {};
  metering.aa = {};
  metering.bloom = 0;
  metering.fogDensity = 0;  // the fog's color is that after exposure
  metering.display = false;
  metering.aovs = {output::Aov::Color};
  // The history belongs to the pictures, and its filter is spatial in the first frame.
  if (metering.indirectFilter == IndirectFilter::Temporal) metering.indirectFilter = IndirectFilter::Spatial;
  metering.countSurfaces = metering.describeGraph = false;
  return metering;
}

namespace {

// Returns the state of the scene without its previous and next frames.
SceneState stillState(const SceneState& state) {
  SceneState still = state;
  still.previousCameras.clear(), still.nextCameras.clear();
  still.motion.sincePrevious.clear(), still.motion.untilNext.clear();
  still.continues = false;
  return still;
}

// Fills the lists per camera with those of the cameras with these indices.
void selectCameras(SceneState& still, const SceneState& all, const std::vector<size_t>& cameras) {
  for (const auto list : {&SceneState::shutters, &SceneState::readouts, &SceneState::exposures}) {
    if ((all.*list).empty()) continue;
    (still.*list).clear();
    for (const size_t camera : cameras) (still.*list).push_back((all.*list)[camera]);
  }
  if (all.motion.cameraAt)
    still.motion.cameraAt = [cameraAt = all.motion.cameraAt, cameras](size_t i, double seconds) {
      return cameraAt(cameras[i], seconds);
    };
}

}  // namespace

std::vector<float> Renderer::meter(std::span<const scene::Camera> cameras, const Settings& settings,
                                   const SceneState& moment) {
  const bool bends = !cameras.empty() && bendsRays(cameras.front());
  const Settings metering = meteringSettings(settings, bends);
  SceneState still = stillState(moment);
  // Worlds that shaders place are rendered together in each round.
  const bool placed = moment.worlds.inputs.has_value();
  const size_t count = cameras.size() * (placed ? moment.worlds.count : 1);
  std::vector<double> ev(count, 0);
  std::vector<bool> settled(count, false);
  for (int round = 0; round < kMaxRounds && !std::ranges::all_of(settled, std::identity{}); ++round) {
    std::vector<scene::Camera> some(cameras.begin(), placed ? cameras.end() : cameras.begin());
    std::vector<size_t> views;
    std::vector<float> factors;
    for (size_t view = 0; view < count; ++view) {
      if (settled[view] && !placed) continue;
      if (!placed) some.push_back(cameras[view]);
      views.push_back(view), factors.push_back(factorOf(ev[view]));
    }
    if (!placed) selectCameras(still, moment, views);
    const std::shared_ptr<RenderJob> job =
        start(some, metering, still, stripsOf(metering), Results::ToHost, {}, std::move(factors));
    finish(*job);
    for (size_t i = 0; i < views.size(); ++i) {
      if (settled[views[i]]) continue;
      const output::AovImage& color = job->result.frames[i].aovs.front();
      const std::optional<double> mean = meanLogLuminance(color);
      double& current = ev[views[i]];
      const double change = mean ? std::log2(kMeteredGray) - *mean : covers(color) ? kDarkStops : 0;
      current += change;
      if (!mean && round + 1 == kMaxRounds) current = 0;  // the surfaces are black
      settled[views[i]] = std::abs(change) <= kPreciseStops;
    }
  }
  std::vector<float> factors;
  for (size_t view = 0; view < count; ++view) {
    const bool own = !moment.exposures.empty();
    const auto compensation = own ? static_cast<float>(std::exp2(moment.exposures[view])) : exposureFactor(settings);
    factors.push_back(factorOf(ev[view]) * compensation);
  }
  return factors;
}

}  // namespace latelight::render
