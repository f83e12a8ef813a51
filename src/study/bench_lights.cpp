// `bench lights`: measures every technique in compute over numbers of lights.
#include "base/error.h"
#include "base/log.h"
#include "render/lighting/technique.h"
#include "study/bench.h"
#include "study/bench_lighting.h"
#include "study/light_bound.h"

namespace latelight::study {

LightsBench::LightsBench(const Ceilings& ceilings, const BenchOptions& options)
    : ceilings_(ceilings),
      options_(options),
      table_{"lights",
             {"lighting", "lights", "lists ms", "lighting ms", "spread %", "MB", "% of copies", "tested per pixel",
              "used per pixel", "ps per used light"},
             {}} {}

// Skips techniques whose predicted time exceeds the budget: with a million lights, those that iterate over all lights
// require seconds per frame.
bool LightsBench::shouldContinue(const render::TechniqueInfo& technique, uint64_t lights) const {
  if (technique.draws) return false;
  const auto line = lines_.find(&technique);
  if (line == lines_.end()) return true;
  if (line->second.stopped()) return false;
  return 1e-3 * line->second.expected(static_cast<double>(lights)).value_or(0) * (options_.frames + 1) <=
         options_.budget;
}

void LightsBench::add(render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
                      const render::Settings& settings, uint64_t lights) {
  const render::TechniqueInfo floor = lightBound(0, 0);
  std::vector<render::Settings> all(1, settings);
  all.front().lighting = &floor;
  std::vector<LightCounts> counts(1);
  for (const render::TechniqueInfo& technique : render::techniques()) {
    if (!shouldContinue(technique, lights)) continue;
    all.push_back(settings);
    all.back().lighting = &technique;
    try {
      counts.push_back(countLights(renderer, camera, moment, all.back()));
    } catch (const Error& error) {
      if (error.code() != ExitCode::Usage) throw;
      warn("{} lights: {}", lights, error.what());  // more lights than the technique supports on this device
      lines_[&technique].stop();
      all.pop_back();
    }
  }
  const std::vector<PassSamples> samples = measureInterleaved(renderer, camera, moment, all, options_.frames);
  const double floorTime = lightTimes(samples.front()).both();
  for (size_t i = 1; i < all.size(); ++i) {
    const LightTimes times = lightTimes(samples[i]);
    lines_[all[i].lighting].add(static_cast<double>(lights), times.both());
    std::vector<Cell>& row = table_.rows.emplace_back(std::vector<Cell>{
        all[i].lighting->name, static_cast<double>(lights), cellOf(times.lists), times.lighting, times.spread});
    addCopyCells(row, ceilings_, times.trafficBytes, times.lighting);
    row.insert(row.end(), {counts[i].tested, counts[i].used,
                           cellOf(picosecondsPerLight(times.both() - floorTime, counts[i].used, all[i]))});
  }
}

}  // namespace latelight::study
