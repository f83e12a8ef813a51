// The study of lights at a small size, and its components on known numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <string_view>

#include "base/error.h"
#include "render/lighting/technique.h"
#include "study/fit.h"
#include "study/plot.h"
#include "study/study.h"
#include "study/sweep.h"

namespace latelight::study {
namespace {

using testing::HasSubstr;

Options tiny() {
  const char* name = std::getenv("LATELIGHT_TEST_DEVICE");
  Options options{.device = name && *name ? name : "cpu", .validation = true};
  // However slow the machine is, no step is skipped. 40 lights are enough for light lists.
  options.sweep = {.budget = 1e6, .lights = {40, 1}, .triangles = {50'000}, .sizes = {{48, 27}}};
  return options;
}

const Table& tableCalled(const Result& result, std::string_view name) {
  return *std::find_if(result.tables.begin(), result.tables.end(), [&](const Table& t) { return t.name == name; });
}

const Cell& cell(const Table& table, const std::vector<Cell>& row, const std::string& column) {
  const auto found = std::find(table.columns.begin(), table.columns.end(), column);
  if (found == table.columns.end()) throw std::out_of_range(column);
  return row[static_cast<size_t>(found - table.columns.begin())];
}

std::string text(const Table& table, const std::vector<Cell>& row, const std::string& column) {
  return std::get<std::string>(cell(table, row, column));
}

double number(const Table& table, const std::vector<Cell>& row, const std::string& column) {
  return std::get<double>(cell(table, row, column));
}

// --- the study ------------------------------------------------------------------------------------------------------

const Result& study() {
  static const Result result = studyLights(tiny());
  return result;
}

TEST(LightStudy, MeasuresEveryTechniqueAtEveryPlace) {
  const Table& table = tableCalled(study(), "lights");
  std::set<std::string> seen;
  for (const std::vector<Cell>& row : table.rows) {
    SCOPED_TRACE(text(table, row, "technique"));
    if (text(table, row, "sweep") == "lights") seen.insert(text(table, row, "technique"));
    EXPECT_EQ(text(table, row, "note"), "");
    EXPECT_NEAR(number(table, row, "triangles"), 50'000, 1'500);
    EXPECT_GE(number(table, row, "frames"), 3);
    EXPECT_GT(number(table, row, "depth ms"), 0);
    EXPECT_GT(number(table, row, "lighting ms"), 0);
    EXPECT_NEAR(number(table, row, "lit ms"),
                number(table, row, "depth ms") + number(table, row, "geometry ms") + number(table, row, "lighting ms"),
                1e-9);
    const bool forward = render::findTechnique(text(table, row, "technique")).forward;
    EXPECT_EQ(number(table, row, "geometry ms") == 0, forward);
    EXPECT_EQ(number(table, row, "G-buffer B/px"), forward ? 12 : 28);  // depth and light accumulation; with `compact`
    // The memory of a frame includes at least its targets.
    EXPECT_GE(number(table, row, "frame MiB") * (1 << 20), 48 * 27 * number(table, row, "G-buffer B/px"));
  }
  EXPECT_EQ(seen.size(), render::techniques().size());
  EXPECT_EQ(table.rows.size(), render::techniques().size() * (2 + 1 + 1));
}

TEST(LightStudy, CountsLights) {
  const Table& table = tableCalled(study(), "lights");
  std::map<double, std::set<double>> used;  // by lights
  for (const std::vector<Cell>& row : table.rows) {
    if (text(table, row, "sweep") != "lights") continue;
    EXPECT_LE(number(table, row, "lights used/px"), number(table, row, "lights tested/px"));
    EXPECT_LE(number(table, row, "lights tested/px"), number(table, row, "lights"));
    used[number(table, row, "lights")].insert(std::round(100 * number(table, row, "lights used/px")));
    if (text(table, row, "technique") == "fullscreen") {
      EXPECT_GT(number(table, row, "lights tested/px"), 0.9 * number(table, row, "lights"));
    }
  }
  ASSERT_EQ(used.size(), 2u);
  // equal for all techniques, except for rounding at the boundary of a light's range
  for (const auto& [lights, means] : used) {
    EXPECT_LE(*means.rbegin() - *means.begin(), 1) << lights;
    EXPECT_GT(*means.begin(), 0) << lights;
  }
}

TEST(LightStudy, WritesPassesOfEveryMeasurement) {
  const Table& table = tableCalled(study(), "lights-passes");
  std::set<std::string> passes;
  for (const std::vector<Cell>& row : table.rows)
    if (text(table, row, "technique") == "tiled") passes.insert(text(table, row, "pass"));
  for (const char* pass : {"clear covered tiles", "covered tiles", "fill"}) passes.erase(pass);  // on CPU devices
  EXPECT_EQ(passes, (std::set<std::string>{"depth", "geometry compact", "light lists", "lighting tiled", "compose"}));
}

// No step is below the limit: only the first one of a line runs, because nothing predicts its time.
TEST(LightStudy, StopsWhereTheNextStepWouldTakeTooLong) {
  Options options = tiny();
  options.validation = false;  // the same frames again
  options.sweep.lights = {1, 4, 16};
  options.sweep.budget = 1e-6;
  const Result result = studyLights(options);
  const Table& table = tableCalled(result, "lights");
  size_t measured = 0, skipped = 0;
  for (const std::vector<Cell>& row : table.rows) {
    if (text(table, row, "sweep") != "lights") continue;
    const bool first = number(table, row, "lights") == 1;
    EXPECT_EQ(number(table, row, "frames"), first ? 1 : 0);
    EXPECT_THAT(text(table, row, "note"), first ? HasSubstr("") : HasSubstr("skipped: next step would take about"));
    ++(first ? measured : skipped);
  }
  EXPECT_EQ(measured, render::techniques().size());
  EXPECT_EQ(skipped, render::techniques().size());  // once per technique, so 16 lights are not measured again
}

TEST(LightStudy, RefusesWhatTheHallCannotHave) {
  Options options = tiny();
  options.sweep.triangles = {9'999};
  EXPECT_THROW(studyLights(options), Error);
  options = tiny();
  options.sweep.sizes = {{0, 27}};
  EXPECT_THROW(studyLights(options), Error);
}

// --- components -----------------------------------------------------------------------------------------------------

TEST(Fit, FindsTheExponent) {
  const std::vector<Sample> cubic{{1, 2}, {10, 2000}, {100, 2e6}, {0, 5}, {3, -1}};  // the last two are ignored
  const auto fit = fitPower(cubic);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->exponent, 3, 1e-12);
  EXPECT_NEAR(fit->factor, 2, 1e-11);
  EXPECT_NEAR(fit->r2, 1, 1e-12);
  EXPECT_FALSE(fitPower(std::vector<Sample>{{5, 1}, {5, 2}}));
  EXPECT_FALSE(fitPower(std::vector<Sample>{}));
}

// Sums and products of lights and triangles: each model explains its own data, and not the other's.
TEST(Fit, TellsASumFromAProduct) {
  std::vector<std::vector<double>> sums, products;
  std::vector<double> sum, product;
  for (double lights : {1.0, 8.0, 64.0}) {
    for (double triangles : {5e4, 3e5, 1e6}) {
      sums.push_back({1, lights, triangles});
      products.push_back({1, lights * triangles});
      sum.push_back(3 + 0.5 * lights + 2e-5 * triangles);
      product.push_back(3 + 1e-6 * lights * triangles);
    }
  }
  const auto right = fitLinear(sums, sum);
  ASSERT_TRUE(right);
  EXPECT_NEAR(right->coefficients[0], 3, 1e-9);
  EXPECT_NEAR(right->coefficients[1], 0.5, 1e-9);
  EXPECT_NEAR(right->coefficients[2], 2e-5, 1e-14);
  EXPECT_NEAR(right->r2, 1, 1e-12);
  EXPECT_NEAR(fitLinear(products, product)->r2, 1, 1e-12);
  EXPECT_LT(fitLinear(products, sum)->r2, 0.9);
  EXPECT_LT(fitLinear(sums, product)->r2, 0.9);
  for (std::vector<double>& row : sums) row[2] = 5e4;  // as if there were only one number of triangles
  EXPECT_FALSE(fitLinear(sums, sum));
}

TEST(Fit, LeavesOutWhatCostsTheSameAnyway) {
  const auto xs = [](std::vector<Sample> sweep) {
    std::vector<double> x;
    for (const Sample& sample : increasingPart(std::move(sweep))) x.push_back(sample.x);
    return x;
  };
  EXPECT_EQ(xs({{1, 10}, {10, 11}, {100, 20}, {1000, 110}}), (std::vector<double>{100, 1000}));
  EXPECT_EQ(xs({{1, 10}, {10, 11}, {100, 10}, {1000, 12}}), (std::vector<double>{10, 100, 1000}));
  EXPECT_EQ(xs({{1, 10}, {10, 100}}), (std::vector<double>{1, 10}));
  EXPECT_TRUE(xs({}).empty());
}

TEST(SweepLine, GrowsAsItGrewLast) {
  SweepLine line;
  EXPECT_FALSE(line.expected(1));
  line.add(1, 0.5);
  EXPECT_NEAR(*line.expected(100), 5, 1e-12);
  line.add(100, 5);  // the root
  EXPECT_NEAR(*line.expected(10'000), 50, 1e-9);
  line.add(1000, 4);  // noise: the prediction never decreases
  EXPECT_NEAR(*line.expected(10'000), 4, 1e-12);
  line.add(2000, 4000);  // noise: the prediction never grows faster than the square
  EXPECT_NEAR(*line.expected(4000), 16'000, 1e-6);
}

// The axes run from 1 to 100 lights (x from 75 to 736) and from 1 to 10 ms (y from 340 to 24).
TEST(PlotSvg, PutsSamplesBetweenTheirPowersOfTen) {
  const Plot plot{
      "p",
      "a <title> & \"more\"",
      "lights",
      "ms",
      {{"one", {{1, 1}, {10, 10}, {100, std::sqrt(10.0)}}}, {"gone", {{1, 0}}}, {"two", {{10, 1}, {10, -1}}}}};
  const std::string svg = svgOf(plot);
  EXPECT_EQ(svg, svgOf(plot));
  EXPECT_THAT(svg, HasSubstr("<title>a &lt;title&gt; &amp; &quot;more&quot;</title>"));
  EXPECT_THAT(svg, HasSubstr("class=\"part0\" points=\"75.0,340.0 405.5,24.0 736.0,182.0 \"><title>one</title>"));
  EXPECT_THAT(svg, HasSubstr("<circle class=\"part1\" cx=\"405.5\" cy=\"340.0\" r=\"3.5\"/>\n"));
  EXPECT_THAT(svg, testing::Not(HasSubstr("gone")));
  EXPECT_EQ(drawPlot(plot).curves, (std::vector<std::string>{"one", "two"}));
}

TEST(PlotSvg, LabelsPowersOfTenWithPrefixes) {
  const std::string svg = svgOf({"p", "t", "x", "y", {{"c", {{1000, 0.01}, {1e6, 0.1}}}}});
  for (const char* tick : {">1k<", ">10k<", ">100k<", ">1M<", ">0.01<", ">0.1<"}) EXPECT_THAT(svg, HasSubstr(tick));
}

TEST(PlotSvg, IsEmptyWithoutPositiveSamples) {
  EXPECT_EQ(svgOf({"p", "t", "x", "y", {{"c", {{1, 0}, {-1, 1}}}}}), "");
}

}  // namespace
}  // namespace latelight::study
