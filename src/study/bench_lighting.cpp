#include "study/bench_lighting.h"

namespace latelight::study {

LightTimes lightTimes(const PassSamples& passes) {
  Milliseconds lists(passes.all.size()), lighting = lists, both = lists;
  LightTimes times;
  for (const auto& [name, samples] : passes.of) {
    if (!name.starts_with("light")) continue;
    const bool lights = name != "light lists";
    for (size_t i = 0; i < samples.size(); ++i) {
      (lights ? lighting : lists)[i] += samples[i];
      both[i] += samples[i];
    }
    if (lights) times.trafficBytes += passes.trafficBytes.at(name);
  }
  times.lists = median(lists);
  times.lighting = median(lighting);
  times.spread = spread(both);
  return times;
}

double picosecondsPerLight(double milliseconds, double usedPerPixel, const render::Settings& settings) {
  const double used = usedPerPixel * settings.width * settings.height;
  return used > 0 ? 1e9 * milliseconds / used : 0;
}

Cell cellOf(double value) {
  return value == 0 ? Cell("") : Cell(value);
}

}  // namespace latelight::study
