// latelight bench: what it measures, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/process.h"

namespace latelight::app {
namespace {

using nlohmann::json;
using testing::HasSubstr;

Outcome bench(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "bench");
  return latelight(std::move(arguments));
}

TEST(Bench, MeasuresRandomTrianglesWithBothRasters) {
  const Outcome outcome = bench({"raster", "--device", "cpu", "--most", "10k", "--runs", "1", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json report = json::parse(outcome.out);
  EXPECT_NE(report["device"], "");
  ASSERT_EQ(report["raster"].size(), 1u);  // the row of 10k triangles
  for (const json& row : report["raster"]) {
    EXPECT_GT(row["hardware ms"], 0);
    EXPECT_GT(row["compute ms"], 0);
  }
}

TEST(Bench, MeasuresAFramePassByPass) {
  const Outcome outcome =
      bench({"frame", "builtin:boxes", "--device", "cpu", "--size", "64x48", "--runs", "2", "--shadows", "none"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  for (const char* part : {"hardware", "geometry compact", "compute", "raster cull", "compose", "hardware / compute"})
    EXPECT_THAT(outcome.out, HasSubstr(part));
}

TEST(Bench, MeasuresManyViews) {
  const Outcome outcome = bench({"views", "builtin:boxes", "--device", "cpu", "--size", "16x16", "--views", "8",
                                 "--runs", "2", "--aov", "depth,id", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json rows = json::parse(outcome.out)["views"];
  ASSERT_EQ(rows.size(), 2u);
  for (const json& row : rows) EXPECT_FLOAT_EQ(row["views a second"], 8000 / row["ms"].get<float>());
}

TEST(Bench, SaysWhatItCannotDo) {
  const std::pair<std::vector<std::string>, const char*> wrong[] = {
      {{}, "raster, frame or views"},
      {{"views", "--views", "0"}, "--views"},
      {{"raster", "--most", "many"}, "--most takes a number"},
      {{"raster", "--runs", "0"}, "--runs"},
      {{"frame", "-o", "x.png"}, "leave -o out"},
      {{"frame", "--raster", "compute"}, "leave --raster out"},
      {{"frame", "builtin:nothing"}, "no built-in scene"},
  };
  for (const auto& [arguments, words] : wrong) {
    const Outcome outcome = bench(arguments);
    EXPECT_EQ(outcome.code, 2) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr(words));
    EXPECT_EQ(outcome.out, "");
  }
}

}  // namespace
}  // namespace latelight::app
