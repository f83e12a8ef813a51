// The cost of lighting: every lighting technique over lights, triangles and pixels. Textbooks claim that forward
// lighting costs lights x triangles and deferred lighting lights + triangles. A grid over both, with lights that reach
// everything, distinguishes the two.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <tuple>

#include "base/error.h"
#include "base/log.h"
#include "base/stopwatch.h"
#include "render/lighting/technique.h"
#include "render/options/options.h"
#include "render/submit/renderer.h"
#include "scene/builtin/builtin.h"
#include "scene/load/load.h"
#include "scene/simplify.h"
#include "study/light_counts.h"
#include "study/pass_samples.h"
#include "study/plot.h"
#include "study/study.h"
#include "study/sweep.h"
#include "vk/memory.h"

namespace latelight::study {

namespace {

using render::TechniqueInfo;
using Size = std::pair<uint32_t, uint32_t>;

// Frames per measurement; the first one warms caches. Fewer frames are measured if they exceed the budget, and more if
// they are short. On a GPU, measurements last at least kWarmUp.
constexpr uint32_t kFrames = 3, kMaxFrames = 10;
constexpr double kShort = 0.1;         // seconds, for all frames of a measurement
constexpr uint64_t kBaseLights = 100;  // upper limit; the base point uses the largest listed count within it
constexpr uint64_t kGridLights[] = {1, 10, 100};
constexpr float kEverywhere = 1000;  // meters: larger than the hall

constexpr std::string_view kOverLights = "lights", kOverTriangles = "triangles", kOverSize = "size", kGrid = "grid";

// --- subjects --------------------------------------------------------------------------------------------------------

struct SweepPoint {
  bool everywhere = false;  // all lights reach the whole hall; otherwise their radius shrinks with their number
  uint64_t triangles = 0, lights = 0;
  Size size;
  auto operator<=>(const SweepPoint&) const = default;
};

// A point as a step of the sweeps to which it belongs. A technique stops at a point if any of these sweeps has stopped.
struct SweepStep {
  size_t number;  // in the plan
  std::string_view sweep;
  SweepPoint point;
  std::vector<std::pair<std::string, double>> lines;  // name, position along it
};

struct Measurement {
  std::vector<graph::PassTime> passes;  // the minimum of each pass
  uint32_t frames = 0;
  double seconds = 0;                 // per frame, the minimum, measured on the host
  double bytes = 0;                   // device memory in addition to the scene's
  uint64_t triangles = 0;             // as built
  std::optional<LightCounts> counts;  // only in the sweep over lights

  double sum(const std::function<bool(const std::string&)>& matches) const {
    double milliseconds = 0;
    for (const graph::PassTime& pass : passes)
      if (matches(pass.name)) milliseconds += pass.milliseconds;
    return milliseconds;
  }
  static bool isDepth(const std::string& pass) { return pass == "depth"; }
  static bool isGeometry(const std::string& pass) { return pass.starts_with("geometry "); }
  static bool isPost(const std::string& pass) { return pass == "compose"; }
  double depth() const { return sum(isDepth); }
  double geometry() const { return sum(isGeometry); }
  double lighting() const {
    return sum([](const std::string& pass) { return !isDepth(pass) && !isGeometry(pass) && !isPost(pass); });
  }
  double lit() const { return depth() + geometry() + lighting(); }
};

struct Row {
  SweepStep step;
  const TechniqueInfo* technique;
  Measurement measured;  // no frames: skipped
  std::string note;
};

// --- the plan -------------------------------------------------------------------------------------------------------

constexpr uint64_t kCoarsestHall = 50'000;  // triangles; smaller halls are simplified from this one
constexpr uint64_t kFewestTriangles = 10'000;

SweepOptions withDefaults(SweepOptions o, bool cpu) {
  const auto fill = [](auto& list, const auto& values) {
    if (list.empty()) list = values;
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  using Counts = std::vector<uint64_t>;
  using Sizes = std::vector<Size>;
  fill(o.lights,
       cpu ? Counts{1, 10, 100, 1'000, 10'000, 100'000} : Counts{1, 10, 100, 1'000, 10'000, 100'000, 1'000'000});
  fill(o.triangles, cpu ? Counts{10'000, 50'000, 300'000, 1'000'000}
                        : Counts{10'000, 50'000, 100'000, 300'000, 1'000'000, 3'000'000, 10'000'000});
  fill(o.sizes,
       cpu ? Sizes{{160, 90}, {320, 180}, {640, 360}, {1280, 720}} : Sizes{{1280, 720}, {1920, 1080}, {3840, 2160}});
  return o;
}

// Varies one list at a time from the base point. Then adds the grid, if there are at least two triangle counts.
std::vector<SweepStep> planSteps(const SweepOptions& o) {
  const auto few = std::upper_bound(o.lights.begin(), o.lights.end(), kBaseLights);
  // Lights and sizes vary in a hall that is not simplified.
  const auto whole =
      std::find_if(o.triangles.begin(), o.triangles.end(), [](uint64_t t) { return t >= kCoarsestHall; });
  const SweepPoint base{false, whole == o.triangles.end() ? o.triangles.front() : *whole,
                        few == o.lights.begin() ? o.lights.front() : *(few - 1), o.sizes.front()};
  std::vector<SweepStep> steps;
  const auto add = [&](std::string_view sweep, const SweepPoint& point, double x) {
    steps.push_back({steps.size(), sweep, point, {{std::string(sweep), x}}});
  };
  for (uint64_t lights : o.lights) add(kOverLights, {false, base.triangles, lights, base.size}, double(lights));
  for (uint64_t triangles : o.triangles)
    add(kOverTriangles, {false, triangles, base.lights, base.size}, double(triangles));
  for (const Size& size : o.sizes)
    add(kOverSize, {false, base.triangles, base.lights, size}, double(size.first) * size.second);
  if (o.triangles.size() < 2) return steps;
  for (uint64_t triangles : o.triangles)
    for (uint64_t lights : kGridLights)
      steps.push_back({steps.size(),
                       kGrid,
                       {true, triangles, lights, base.size},
                       {{fmt::format("grid, {} triangles", triangles), double(lights)},
                        {fmt::format("grid, {} lights", lights), double(triangles)}}});
  return steps;
}

// Performs all checks before any expensive work.
void check(const SweepOptions& o) {
  const auto hall = std::find_if(scene::builtins().begin(), scene::builtins().end(),
                                 [](const scene::Builtin& builtin) { return builtin.name == "hall"; });
  const auto inRange = [&](std::string_view key, std::span<const uint64_t> values) {
    for (const scene::BuiltinParameter& p : hall->parameters)
      for (uint64_t value : values)
        if (const uint64_t least = key == "triangles" ? kFewestTriangles : p.least;
            p.key == key && (value < least || value > p.most))
          badUsage("builtin:hall, the scene of the study of lights, can have {} to {} {}, not {}; change --{}", least,
                   p.most, key, value, key);
  };
  inRange("triangles", o.triangles);
  inRange("lights", o.lights);
  for (const Size& size : o.sizes) checkSettings(render::Settings{.width = size.first, .height = size.second});
}

// --- measuring ------------------------------------------------------------------------------------------------------

void keepMinimum(std::vector<graph::PassTime>& least, const std::vector<graph::PassTime>& times) {
  for (size_t i = 0; i < least.size(); ++i)
    least[i].milliseconds = std::min(least[i].milliseconds, times[i].milliseconds);
}

class LightStudy {
 public:
  explicit LightStudy(const Options& options)
      : device_({.selector = options.device, .validation = options.validation}),
        sweep_(withDefaults(options.sweep, device_.isCpu())) {}

  Result run() {
    check(sweep_);
    const std::vector<SweepStep> steps = planSteps(sweep_);
    takeAll(steps);
    for (const std::string& message : device_.validationMessages())
      fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
    return {device_.info().name, {exponents(), models(), measurements(), passes()}, {}, plots()};
  }

 private:
  std::vector<SweepLine*> linesOf(const SweepStep& step, const TechniqueInfo& technique) {
    std::vector<SweepLine*> lines;
    for (const auto& [name, x] : step.lines) lines.push_back(&lines_[{technique.name, name}]);
    return lines;
  }

  // Measures in the order of scenes, so that each scene is created once. Few lights and triangles come first, so every
  // sweep grows. The table keeps the order of the plan.
  void takeAll(const std::vector<SweepStep>& steps) {
    std::vector<const SweepStep*> order;
    for (const SweepStep& step : steps) order.push_back(&step);
    std::stable_sort(order.begin(), order.end(), [](const SweepStep* a, const SweepStep* b) {
      return std::tie(a->point.triangles, a->point.lights) < std::tie(b->point.triangles, b->point.lights);
    });
    Progress progress("Measuring", steps.size() * render::techniques().size());
    for (const SweepStep* step : order) {
      for (const TechniqueInfo& technique : render::techniques()) {
        take(*step, technique);
        progress.step();
      }
    }
    std::stable_sort(rows_.begin(), rows_.end(),
                     [](const Row& a, const Row& b) { return a.step.number < b.step.number; });
  }

  // Measures a step, or reports why it is skipped.
  void take(const SweepStep& step, const TechniqueInfo& technique) {
    const std::vector<SweepLine*> lines = linesOf(step, technique);
    double expected = 0;
    for (size_t i = 0; i < lines.size(); ++i) {
      if (lines[i]->stopped()) return;
      expected = std::max(expected, lines[i]->expected(step.lines[i].second).value_or(0));
    }
    const auto known = measured_.find({technique.name, step.point});
    expected *= kFrames;
    if (known == measured_.end() && expected > sweep_.budget) {
      stop(step, technique,
           fmt::format("skipped: next step would take about {:.3g} s, more than {} (--budget)", expected,
                       sweep_.budget));
      return;
    }
    Measurement m;
    try {
      m = known == measured_.end() ? measure(step.point, technique, step.sweep == kOverLights) : known->second;
    } catch (const Error& error) {
      if (error.code() != ExitCode::Usage) throw;
      stop(step, technique, fmt::format("skipped: {}", error.what()));
      return;
    }
    measured_.emplace(std::pair(technique.name, step.point), m);
    for (size_t i = 0; i < lines.size(); ++i) lines[i]->add(step.lines[i].second, m.seconds);
    rows_.push_back({step, &technique, std::move(m), ""});
  }

  void stop(const SweepStep& step, const TechniqueInfo& technique, std::string note) {
    for (SweepLine* line : linesOf(step, technique)) line->stop();
    warn("{}, {} with {} triangles, {} lights, {}x{}: {}", step.sweep, technique.name, step.point.triangles,
         step.point.lights, step.point.size.first, step.point.size.second, note);
    rows_.push_back({step, &technique, {}, std::move(note)});
  }

  static scene::Scene loadHall(const SweepPoint& point) {
    scene::Scene hall = scene::load(
        fmt::format("builtin:hall,triangles={},lights={}", std::max(point.triangles, kCoarsestHall), point.lights));
    if (point.triangles < kCoarsestHall) scene::simplify(hall, point.triangles);
    return hall;
  }

  // Caches the last scene, because all its measurements precede those of the next scene.
  const scene::Scene& sceneOf(const SweepPoint& point) {
    const std::pair key(point.triangles, point.lights);
    if (sceneKey_ != key || (everywhere_ && !point.everywhere)) scene_ = loadHall(point);
    if (point.everywhere)
      for (scene::Light& light : scene_.lights) light.range = kEverywhere;
    sceneKey_ = key;
    everywhere_ = point.everywhere;
    return scene_;
  }

  Measurement measure(const SweepPoint& point, const TechniqueInfo& technique, bool count) {
    const scene::Scene& scene = sceneOf(point);
    // Each measurement has its own renderer, so that the memory belongs to this technique only.
    render::Renderer renderer(device_, scene, nullptr);
    const uint64_t before = device_.memory().statistics().usedBytes;
    render::Settings settings{.width = point.size.first, .height = point.size.second, .lighting = &technique};
    settings.shadows = render::ShadowFormat::None;  // measures the cost of light, not of shadows
    const std::span<const scene::Camera> camera(&scene.cameras.front(), 1);
    Measurement m{.triangles = scene.triangleCount()};
    const Stopwatch all;
    while (shouldContinue(m.frames, all.seconds())) {
      const Stopwatch frame;
      const std::vector<graph::PassTime> passes = renderer.submit(camera, settings).take().statistics.passTimes;
      const double seconds = frame.seconds();
      m.seconds = m.frames < 2 ? seconds : std::min(m.seconds, seconds);
      if (passes.empty())
        fail(ExitCode::NoDevice, "{} has no timestamps to measure with; choose another --device", device_.info().name);
      if (m.frames < 2) m.passes = passes;
      keepMinimum(m.passes, passes);
      ++m.frames;
    }
    m.bytes = static_cast<double>(device_.memory().statistics().usedBytes - before);
    if (count) m.counts = countLights(renderer, camera.front(), {}, settings);
    return m;
  }

  bool shouldContinue(uint32_t frames, double seconds) const {
    if (frames == 0) return true;
    if (frames < kFrames) return seconds < sweep_.budget;
    return device_.isCpu() ? frames < kMaxFrames && seconds < kShort : seconds < kWarmUp;
  }

  // --- tables -------------------------------------------------------------------------------------------------------

  static std::vector<Cell> keyOf(const Row& row) {
    const SweepPoint& p = row.step.point;
    return {std::string(row.step.sweep),
            row.technique->name,
            p.everywhere ? "everywhere" : "own",
            double(row.measured.frames ? row.measured.triangles : p.triangles),
            double(p.lights),
            double(p.size.first),
            double(p.size.second)};
  }

  // Returns the layout's bytes plus those that every frame requires. A forward technique has no layout.
  static double bytesPerPixel(const TechniqueInfo& technique) {
    const render::Settings settings;
    const render::LayoutBytes bytes = settings.layout->bytesPerPixel(settings.normals->index);
    return technique.forward ? bytes.depth + bytes.light : bytes.total();
  }

  Table measurements() const {
    Table table{
        "lights",
        {"sweep", "technique", "reach", "triangles", "lights", "width", "height", "depth ms", "geometry ms",
         "lighting ms", "lit ms", "G-buffer B/px", "frame MiB", "lights tested/px", "lights used/px", "frames", "note"},
        {},
        false};
    for (const Row& row : rows_) {
      std::vector<Cell>& cells = table.rows.emplace_back(keyOf(row));
      const Measurement& m = row.measured;
      const auto add = [&](bool there, double value) { cells.push_back(there ? Cell(value) : Cell("")); };
      for (const double ms : {m.depth(), m.geometry(), m.lighting(), m.lit()}) add(m.frames, ms);
      add(m.frames, bytesPerPixel(*row.technique));
      add(m.frames, m.bytes / (1 << 20));
      add(m.counts.has_value(), m.counts ? m.counts->tested : 0);
      add(m.counts.has_value(), m.counts ? m.counts->used : 0);
      cells.emplace_back(double(m.frames));
      cells.emplace_back(row.note);
    }
    return table;
  }

  Table passes() const {
    Table table{"lights-passes",
                {"sweep", "technique", "reach", "triangles", "lights", "width", "height", "pass", "ms"},
                {},
                false};
    for (const Row& row : rows_) {
      for (const graph::PassTime& pass : row.measured.passes) {
        std::vector<Cell>& cells = table.rows.emplace_back(keyOf(row));
        cells.emplace_back(pass.name);
        cells.emplace_back(pass.milliseconds);
      }
    }
    return table;
  }

  // An axis of the plots: the varied quantity, the measured part of a frame, and labels.
  struct Axis {
    std::string_view sweep;
    const char *of, *unit;
    double (*x)(const Row& row);
    double (*y)(const Row& row);
  };
  static std::span<const Axis> axes() {
    static constexpr auto lit = [](const Row& row) { return row.measured.lit(); };
    static const Axis all[] = {
        {kOverLights, "Lighting", "lights", [](const Row& row) { return double(row.step.point.lights); },
         [](const Row& row) { return row.measured.lighting(); }},
        {kOverTriangles, "Depth, geometry and lighting", "triangles",
         [](const Row& row) { return double(row.measured.triangles); }, lit},
        {kOverSize, "Depth, geometry and lighting", "pixels",
         [](const Row& row) { return double(row.step.point.size.first) * row.step.point.size.second; }, lit},
    };
    return all;
  }

  std::vector<Sample> samplesOf(const Axis& axis, const TechniqueInfo& technique) const {
    std::vector<Sample> samples;
    for (const Row& row : rows_)
      if (row.technique == &technique && row.measured.frames && row.step.sweep == axis.sweep)
        samples.push_back({axis.x(row), axis.y(row)});
    return samples;
  }

  Table exponents() const {
    Table table{"lights-exponents", {"time of", "against", "technique", "exponent", "R2", "points", "from", "to"}, {}};
    for (const Axis& axis : axes()) {
      for (const TechniqueInfo& technique : render::techniques()) {
        const std::vector<Sample> samples = increasingPart(samplesOf(axis, technique));
        const std::optional<PowerFit> fit = fitPower(samples);
        if (!fit) continue;
        table.rows.push_back({axis.of, axis.unit, technique.name, fit->exponent, fit->r2, double(samples.size()),
                              samples.front().x, samples.back().x});
      }
    }
    return table;
  }

  std::vector<const Row*> gridOf(const TechniqueInfo& technique) const {
    std::vector<const Row*> grid;
    for (const Row& row : rows_)
      if (row.technique == &technique && row.measured.frames && row.step.point.everywhere) grid.push_back(&row);
    return grid;
  }

  // Returns the milliseconds that one additional light costs, against triangles. The difference is taken between one
  // light and the highest count that was measured with at least two triangle counts.
  static std::vector<Sample> costPerLight(const std::vector<const Row*>& grid) {
    for (size_t i = std::size(kGridLights); i-- > 1;) {
      std::vector<Sample> costs;
      for (const Row* many : grid) {
        if (many->step.point.lights != kGridLights[i]) continue;
        for (const Row* one : grid) {
          if (one->step.point.lights != kGridLights[0] || one->measured.triangles != many->measured.triangles) continue;
          costs.push_back({double(one->measured.triangles),
                           (many->measured.lit() - one->measured.lit()) / double(kGridLights[i] - kGridLights[0])});
        }
      }
      if (costs.size() > 1) return costs;
    }
    return {};
  }

  // Fits two models with the same number of constants. Sum: a + b lights + c triangles. Product: a + b triangles + c
  // lights x triangles. Both have a term for triangles, because every technique draws the scene once regardless of
  // lights.
  Table models() const {
    Table table{"lights-model",
                {"technique", "grows with", "R2 of sum", "R2 of product", "points", "ms per light, fewest triangles",
                 "ms per light, most triangles", "from triangles", "to triangles"},
                {}};
    for (const TechniqueInfo& technique : render::techniques()) {
      const std::vector<const Row*> grid = gridOf(technique);
      std::vector<std::vector<double>> sums, products;
      std::vector<double> times;
      for (const Row* row : grid) {
        const double lights = double(row->step.point.lights), triangles = double(row->measured.triangles);
        sums.push_back({1, lights, triangles});
        products.push_back({1, triangles, lights * triangles});
        times.push_back(row->measured.lit());
      }
      const std::optional<LinearFit> sum = fitLinear(sums, times), product = fitLinear(products, times);
      const std::vector<Sample> costs = costPerLight(grid);
      if (!sum || !product || costs.size() < 2) continue;  // too few points of the grid
      table.rows.push_back({technique.name, sum->r2 > product->r2 ? "lights + triangles" : "lights x triangles",
                            sum->r2, product->r2, double(times.size()), costs.front().y, costs.back().y,
                            costs.front().x, costs.back().x});
    }
    return table;
  }

  // --- plots --------------------------------------------------------------------------------------------------------

  std::vector<Plot> plots() const {
    std::vector<Plot> all;
    for (const Axis& axis : axes()) {
      Plot plot{fmt::format("lights-vs-{}", axis.sweep),
                fmt::format("{} against {}, {}", axis.of, axis.unit, device_.info().name),
                axis.unit,
                "milliseconds per frame",
                {}};
      for (const TechniqueInfo& technique : render::techniques())
        plot.curves.push_back({technique.name, samplesOf(axis, technique)});
      all.push_back(std::move(plot));
    }
    Plot each{"lights-each",
              fmt::format("One more light that reaches everything, {}", device_.info().name),
              "triangles",
              "milliseconds per light",
              {}};
    for (const TechniqueInfo& technique : render::techniques())
      each.curves.push_back({technique.name, costPerLight(gridOf(technique))});
    all.push_back(std::move(each));
    return all;
  }

  vk::Device device_;
  SweepOptions sweep_;
  scene::Scene scene_;
  std::pair<uint64_t, uint64_t> sceneKey_;  // triangles and lights of scene_
  bool everywhere_ = false;                 // the radius of its lights
  std::map<std::pair<std::string, SweepPoint>, Measurement> measured_;
  std::map<std::pair<std::string, std::string>, SweepLine> lines_;  // technique, line
  std::vector<Row> rows_;
};

}  // namespace

Result studyLights(const Options& options) {
  return LightStudy(options).run();
}

}  // namespace latelight::study
