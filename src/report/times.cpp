#include "report/times.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "report/chart.h"
#include "report/command.h"
#include "study/pass_samples.h"

namespace latelight::report {

namespace {

struct Timed {
  std::string name;
  render::Settings settings;
  study::PassSamples samples{};
};

// The settings alternate: each frame is followed by one with other settings.
void measure(const Subject& s, std::vector<Timed>& all) {
  std::vector<render::Settings> settings;
  for (const Timed& each : all) settings.push_back(each.settings);
  const std::vector<study::PassSamples> samples =
      study::measureInterleaved(s.renderer, s.camera, s.moment, settings, s.runs);
  for (size_t i = 0; i < all.size(); ++i) all[i].samples = samples[i];
}

double medianOf(const Timed& timed, const std::string& pass) {
  const auto found = timed.samples.of.find(pass);
  return found == timed.samples.of.end() ? 0 : study::median(found->second);
}

// "geometry compact" and "lighting clustered" share a row with those of other layouts and techniques.
std::string kindOf(const std::string& pass, const Timed& timed) {
  for (const std::string& name : {timed.settings.layout->name, timed.settings.lighting->name})
    if (pass.ends_with(" " + name)) return pass.substr(0, pass.size() - name.size() - 1);
  return pass;
}

// Milliseconds by kind of pass, in the order of the passes.
struct Passes {
  std::vector<std::string> kinds;
  std::vector<std::map<std::string, double>> of;  // one map per compared setting
};

Passes collect(const std::vector<Timed>& all) {
  Passes passes;
  for (const Timed& timed : all) {
    auto& times = passes.of.emplace_back();
    for (const std::string& pass : timed.samples.names) {
      const std::string kind = kindOf(pass, timed);
      if (std::ranges::find(passes.kinds, kind) == passes.kinds.end()) passes.kinds.push_back(kind);
      times[kind] += medianOf(timed, pass);
    }
  }
  return passes;
}

// Shows the seven passes with the longest times, and the sum of the rest.
BarChart chartOf(const std::string& title, const std::vector<Timed>& all, const Passes& passes) {
  const auto total = [&](const std::string& kind) {
    double sum = 0;
    for (const auto& times : passes.of) sum += times.contains(kind) ? times.at(kind) : 0;
    return sum;
  };
  BarChart chart{title, "ms", passes.kinds, {}};
  std::ranges::stable_sort(chart.parts, std::greater(), total);
  constexpr size_t kMax = 7;
  const size_t shown = std::min(chart.parts.size(), kMax);
  for (size_t i = 0; i < all.size(); ++i) {
    BarChart::Bar& bar = chart.bars.emplace_back(BarChart::Bar{all[i].name, std::vector<double>(chart.parts.size())});
    for (size_t part = 0; part < chart.parts.size(); ++part)
      if (passes.of[i].contains(chart.parts[part]))
        bar.values[std::min(part, shown)] += passes.of[i].at(chart.parts[part]);
  }
  if (chart.parts.size() > shown) chart.parts.resize(shown), chart.parts.emplace_back("others");
  for (BarChart::Bar& bar : chart.bars) bar.values.resize(chart.parts.size());
  return chart;
}

study::Table tableOf(const std::vector<Timed>& all, const Passes& passes) {
  study::Table table{"times", {"pass, ms"}, {}};
  for (const Timed& timed : all) table.columns.push_back(timed.name);
  for (const std::string& kind : passes.kinds) {
    std::vector<study::Cell>& row = table.rows.emplace_back(std::vector<study::Cell>{kind});
    for (const auto& times : passes.of)
      row.push_back(times.contains(kind) ? study::Cell(times.at(kind)) : study::Cell(""));
  }
  std::vector<study::Cell>& whole = table.rows.emplace_back(std::vector<study::Cell>{"whole frame"});
  for (const Timed& timed : all) whole.emplace_back(study::median(timed.samples.all));
  return table;
}

std::string commandsOf(const Subject& s, const std::vector<Timed>& all) {
  std::string html;
  for (const Timed& timed : all) {
    std::vector<std::string> words = joined({"bench", "frame"}, optionsFor(s, *timed.settings.layout));
    if (!timed.settings.lighting->forward)
      words = joined(std::move(words), std::vector<std::string>{"--layout", timed.settings.layout->name});
    html +=
        commandHtml(joined(std::move(words), std::vector<std::string>{"--lighting", timed.settings.lighting->name,
                                                                      "--raster", render::nameOf(timed.settings.raster),
                                                                      "--runs", fmt::format("{}", s.runs)}));
  }
  return html;
}

std::string compared(const Subject& s, const std::string& title, const std::vector<Timed>& all) {
  const Passes passes = collect(all);
  return fmt::format("<h3>{}</h3>\n", title) + toHtml(chartOf(title, all, passes)) +
         toHtml(tableOf(all, passes), title) + commandsOf(s, all);
}

}  // namespace

std::string timesHtml(const Subject& s) {
  std::vector<Timed> layouts, techniques;
  for (const render::Layout& layout : render::layouts()) {
    const render::Settings settings = settingsFor(s, layout);
    if (settings.raster == s.settings.raster && canLight(s, layout)) layouts.push_back(Timed{layout.name, settings});
  }
  for (const render::TechniqueInfo& technique : render::techniques()) {
    if (!canLight(s, technique)) continue;
    techniques.push_back({technique.name, settingsFor(s, technique)});
  }
  measure(s, layouts);
  measure(s, techniques);
  if (layouts.front().samples.names.empty()) return "<p>This device does not support timestamps.</p>\n";
  return fmt::format("<p>Medians of --runs {} frames that stay on the device, with the raster {}.</p>\n", s.runs,
                     render::nameOf(s.settings.raster)) +
         compared(s, "Layouts", layouts) + compared(s, "Lighting techniques", techniques);
}

}  // namespace latelight::report
