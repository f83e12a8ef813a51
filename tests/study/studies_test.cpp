// The figures of the studies, with fewer samples than the program uses, compared with known and derived ones.
#include "study/study.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/error.h"
#include "shared/normal_bounds.h"
#include "study/picture.h"
#include "study/statistics.h"

namespace latelight::study {
namespace {

Options options() {
  const char* name = std::getenv("LATELIGHT_TEST_DEVICE");
  return {.device = name && *name ? name : "cpu", .validation = true, .samples = 300'000};
}

const Table& tableOf(const Result& result, std::string_view name) {
  return *std::find_if(result.tables.begin(), result.tables.end(), [&](const Table& t) { return t.name == name; });
}

size_t columnOf(const Table& table, const std::string& name) {
  const auto found = std::find(table.columns.begin(), table.columns.end(), name);
  if (found == table.columns.end()) throw std::out_of_range(name);
  return static_cast<size_t>(found - table.columns.begin());
}

// A number of the row whose first cells are `key`.
double value(const Table& table, const std::vector<std::string>& key, const std::string& column) {
  for (const std::vector<Cell>& row : table.rows) {
    bool is = true;
    for (size_t i = 0; i < key.size(); ++i) is = is && std::get<std::string>(row[i]) == key[i];
    if (is) return std::get<double>(row[columnOf(table, column)]);
  }
  throw std::out_of_range(key.front());
}

// --- normals --------------------------------------------------------------------------------------------------------

struct Known {
  const char *encoding, *bits, *region;
  double mean, digit;  // of the mean, in its last printed digit
  double maximum;
};
// In degrees. The program reproduces all digits; fewer directions come within one. Maxima depend on the samples, so two
// sets of directions differ (docs/normals.md).
constexpr Known kKnown[] = {
    {"octahedral", "8+8", "sphere", 0.337, 0.001, 0.949},
    {"octahedral", "10+10", "sphere", 0.0837, 0.0001, 0.237},
    {"octahedral", "12+12", "sphere", 0.0209, 0.0001, 0.0591},
    {"octahedral", "16+16", "sphere", 0.00131, 0.00001, 0.00369},
    {"octahedral-precise", "8+8", "sphere", 0.315, 0.001, 0.636},
    {"spheremap", "8+8", "sphere", 0.492, 0.001, 11.7},
    {"lambert", "8+8", "sphere", 0.492, 0.001, 11.7},
    // Published as .353; 0.3525 is between the two.
    {"spheremap", "8+8", "hemisphere", 0.3525, 0.001, 0.897},
    {"lambert", "8+8", "hemisphere", 0.3525, 0.001, 0.897},
    {"spherical-angles", "8+8", "sphere", 0.355, 0.001, 0.787},
    {"spherical-z", "8+8", "sphere", 0.372, 0.001, 5.08},
    {"xy-z", "8+8", "hemisphere", 0.467, 0.001, 5.88},
    {"xyz", "8+8+8", "sphere", 0.170, 0.001, 0.386},
};

const Result& normals() {
  static const Result result = [] {
    Options o = options();
    o.bits = {8, 10, 12, 16};
    return studyNormals(o);
  }();
  return result;
}

TEST(NormalStudy, ReproducesKnownFigures) {
  const Table& table = tableOf(normals(), "normals");
  for (const Known& known : kKnown) {
    SCOPED_TRACE(std::string(known.encoding) + " " + known.bits + " " + known.region);
    const std::vector<std::string> key{known.encoding, known.bits, known.region};
    for (const char* side : {"", "device "}) {
      EXPECT_NEAR(value(table, key, side + std::string("mean deg")), known.mean, known.digit) << side;
      // 300,000 directions do not reach the smallest regions.
      EXPECT_NEAR(value(table, key, side + std::string("max deg")), known.maximum, 0.05 * known.maximum) << side;
    }
    EXPECT_GT(value(table, key, "rms deg"), value(table, key, "mean deg"));
  }
}

TEST(NormalStudy, NothingIsBeyondItsDerivedBound) {
  const Table& table = tableOf(normals(), "normals");
  for (const std::vector<Cell>& row : table.rows) {
    std::string name = std::get<std::string>(row[0]);
    std::replace(name.begin(), name.end(), '-', '_');
    const std::string& bits = std::get<std::string>(row[1]);
    if (name == "xy_z" && std::get<std::string>(row[2]) == "sphere") continue;  // the far half is lost
    const double levels = std::exp2(std::stod(bits.substr(0, bits.find('+')))) - 1;
    EXPECT_LE(std::get<double>(row[columnOf(table, "max deg")]),
              1.001 * shared::normalBound(name, levels).radians * 180 / M_PI + 3e-4)
        << name << " " << bits;
  }
}

TEST(NormalStudy, HistogramsHoldEveryDirection) {
  const Table& table = tableOf(normals(), "normals-histogram");
  double octahedral = 0, xyZ = 0;
  for (const std::vector<Cell>& row : table.rows) {
    if (std::get<std::string>(row[1]) != "8+8") continue;
    if (std::get<std::string>(row[0]) == "octahedral") octahedral += std::get<double>(row[4]);
    if (std::get<std::string>(row[0]) == "xy-z") xyZ += std::get<double>(row[4]);
  }
  EXPECT_EQ(octahedral, 300'000);
  EXPECT_EQ(xyZ, 150'000);  // the near half
}

// --- depth ----------------------------------------------------------------------------------------------------------

const Result& depths() {
  static const Result result = studyDepth(options());
  return result;
}

TEST(DepthStudy, ExactPackingLosesNothingAndTheClassicLosesOne) {
  const Table& table = tableOf(depths(), "depth-packing");
  for (const std::string column : {"max", "device max"}) {
    EXPECT_EQ(value(table, {"rgba8"}, column), 0.0);
    EXPECT_EQ(value(table, {"d32"}, column), 0.0);
    // Two steps of floats below 1, or one on devices that round the decoding in another way, such as Mesa 26.
    EXPECT_NEAR(value(table, {"rgba8-classic"}, column), 1.2e-7, column == "max" ? 0.05e-7 : 0.65e-7);
    // half a step, plus the rounding of the stored float
    EXPECT_NEAR(value(table, {"d16"}, column), 0.5 / 65535, 0x1p-24);
    EXPECT_NEAR(value(table, {"d24"}, column), 0.5 / 16777215, 1e-9);
  }
  EXPECT_EQ(value(table, {"rgba8"}, "1 becomes"), 1.0);
  EXPECT_EQ(value(table, {"rgba8-classic"}, "1 becomes"), 0.0);
}

// Reversed depth in floats has the relative error of floats; in integers it is as inaccurate as conventional depth.
TEST(DepthStudy, ReversedFloatsKeepRelativeDepth) {
  const Table& table = tableOf(depths(), "depth");
  EXPECT_LT(value(table, {"d32", "reversed infinite"}, "max rel"), 2e-7);
  EXPECT_LT(value(table, {"rgba8", "reversed infinite"}, "device max rel"), 2e-7);
  EXPECT_GT(value(table, {"d32", "conventional"}, "max rel"), 1e-4);
  EXPECT_GT(value(table, {"d24", "reversed infinite"}, "max rel"), 1e-4);
}

// --- position -------------------------------------------------------------------------------------------------------

TEST(PositionStudy, MethodsOnlyDifferByRounding) {
  const Result result = studyPosition(options());
  const Table& table = tableOf(result, "position");
  EXPECT_EQ(table.rows.size(), 6u * 2 * 3);
  for (const char* point : {"centered", "off-center"}) {
    for (const char* method : {"ray", "matrix", "reciprocal"}) {
      EXPECT_LT(value(table, {"reversed infinite", point, method}, "max m"), 1e-3);
      EXPECT_LT(value(table, {"orthographic conventional", point, method}, "device max m"), 1e-3);
    }
    // d - A is exact near the far plane; P d + Q, rounded twice, is not.
    EXPECT_LT(value(table, {"conventional", point, "ray"}, "own max m"), 1e-3);
    EXPECT_GT(value(table, {"conventional", point, "matrix"}, "own max m"), 0.1);
  }
}

// --- components -----------------------------------------------------------------------------------------------------

TEST(Statistics, CountEvenSamplesAndFindTheWorstOfAll) {
  const std::vector<double> errors{3, 1, INFINITY, 2, 9};
  const Statistics s = summarize(errors, 4, [](size_t i) { return i != 1; });
  EXPECT_EQ(s.count, 2u);
  EXPECT_EQ(s.lost, 1u);
  EXPECT_EQ(s.mean(), 2.5);
  EXPECT_EQ(s.rms(), std::sqrt(6.5));
  EXPECT_EQ(s.maximum, 9);
  EXPECT_EQ(s.worst, 4u);
}

TEST(Table, QuotesCsvAndWritesInfinity) {
  const Table table{"t", {"name", "value"}, {{"a, \"b\"", 0.125}, {"c", INFINITY}}};
  EXPECT_EQ(toCsv(table), "name,value\r\n\"a, \"\"b\"\"\",0.125\r\nc,inf\r\n");
  EXPECT_EQ(toJson(table).dump(), R"([{"name":"a, \"b\"","value":0.125},{"name":"c","value":"inf"}])");
  EXPECT_EQ(toText(table), "name    value\na, \"b\"  0.125\nc         inf\n");
}

TEST(SphereMap, ShowsBothHalves) {
  const output::Picture map = spherePicture(sphereMap([](shared::vec3 d) { return d.z > 0 ? 0.0 : 1.0; }), 1);
  const auto red = [&](uint32_t x, uint32_t y) { return map.rgba[(size_t{y} * map.width + x) * 4]; };
  EXPECT_EQ(red(map.height / 2, map.height / 2), 0);
  EXPECT_EQ(red(map.height + map.height / 2, map.height / 2), 255);
}

TEST(Studies, AreFoundByName) {
  EXPECT_STREQ(findStudy("depth").name, "depth");
  EXPECT_THROW(findStudy("light years"), Error);
}

}  // namespace
}  // namespace latelight::study
