// `bench shade`: measures the cost of a light at the lower bound and with the technique of the settings.
#include <array>
#include <span>
#include <vector>

#include "render/lighting/technique.h"
#include "scene/light_types.h"
#include "shared/light.h"
#include "study/bench.h"
#include "study/bench_lighting.h"
#include "study/light_bound.h"

namespace latelight::study {

namespace {

constexpr uint32_t kFew = 16, kMany = 64;  // lights; the cost of additional lights is linear

// The lower bound for one type of light.
struct Bound {
  explicit Bound(uint32_t type) : techniques{lightBound(type, 0), lightBound(type, kFew), lightBound(type, kMany)} {}
  std::array<render::TechniqueInfo, 3> techniques;
};

struct BoundCost {
  LightTimes floor;        // without lights
  double picoseconds = 0;  // per light that a pixel uses
};

BoundCost costOf(std::span<const PassSamples> samples, std::span<const LightCounts> counts,
                 const render::Settings& settings) {
  const double more = lightTimes(samples[2]).both() - lightTimes(samples[1]).both();
  return {lightTimes(samples[0]), picosecondsPerLight(more, counts[2].used - counts[1].used, settings)};
}

// Adds the rows of one shading model. The technique of the settings is the last measurement.
void addRows(Table& table, render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
             const render::Settings& settings, const Ceilings& ceilings, uint32_t frames) {
  std::vector<Bound> bounds;
  std::vector<std::string> names;
  for (uint32_t type = 0; type < scene::lightTypes().size(); ++type) {
    if (shared::lightIsArea(type)) continue;  // not shaded per light
    bounds.emplace_back(type);
    names.emplace_back(scene::lightTypes()[type].name);
  }
  std::vector<render::Settings> all;
  for (const Bound& bound : bounds)
    for (const render::TechniqueInfo& technique : bound.techniques) {
      all.push_back(settings);
      all.back().lighting = &technique;
    }
  all.push_back(settings);
  std::vector<LightCounts> counts;
  for (const render::Settings& s : all) counts.push_back(countLights(renderer, camera, moment, s));
  const std::vector<PassSamples> samples = measureInterleaved(renderer, camera, moment, all, frames);
  const double technique = lightTimes(samples.back()).both();
  for (size_t i = 0; i < bounds.size(); ++i) {
    const BoundCost cost = costOf(std::span(samples).subspan(3 * i, 3), std::span(counts).subspan(3 * i, 3), settings);
    const double used = picosecondsPerLight(technique - cost.floor.both(), counts.back().used, settings);
    std::vector<Cell>& row = table.rows.emplace_back(
        std::vector<Cell>{names[i], render::nameOf(settings.shading), cost.floor.both(), cost.floor.spread});
    addCopyCells(row, ceilings, cost.floor.trafficBytes, cost.floor.both());
    row.insert(row.end(), {cost.picoseconds, 1e3 / cost.picoseconds, 1e-12 * cost.picoseconds * ceilings.multiplyAdds,
                           settings.lighting->name, cellOf(used), cellOf(used / cost.picoseconds)});
  }
}

}  // namespace

Table benchShade(render::Renderer& renderer, const scene::Camera& camera, const render::SceneState& moment,
                 const render::Settings& settings, const Ceilings& ceilings, const BenchOptions& options) {
  Table table{"shade",
              {"light", "shading", "no lights ms", "spread %", "MB", "% of copies", "ps a light", "G lights/s",
               "multiply-adds", "lighting", "ps per used light", "to the bound"},
              {}};
  const size_t ways = render::choices<render::Shading>().size();
  for (uint32_t i = 0; i < ways; ++i) {
    render::Settings s = settings;
    s.shading = static_cast<render::Shading>(i);
    addRows(table, renderer, camera, moment, s, ceilings, options.frames);
  }
  return table;
}

}  // namespace latelight::study
