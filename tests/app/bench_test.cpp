// latelight bench: its measurements, and the arguments that it rejects.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>

#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "app/folder.h"
#include "app/process.h"
#include "long_tests.h"
#include "output/read.h"

namespace latelight::app {
namespace {

using nlohmann::json;
using testing::HasSubstr;

Outcome bench(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "bench");
  return latelight(std::move(arguments));
}

// Every view has a world of its own; the time of the host is part of the whole.
TEST(Bench, MeasuresManyWorlds) {
  const Outcome one = bench({"worlds", "builtin:boxes", "--device", "cpu", "--size", "16x16", "--worlds", "4", "--runs",
                             "1", "--raster", "rays", "--aov", "depth", "--json"});
  ASSERT_EQ(one.code, 0) << one.text();
  for (const json& row : json::parse(one.out)["worlds"]) EXPECT_EQ(row["raster"], "rays");
  const Outcome measured = bench({"worlds", "builtin:boxes", "--device", "cpu", "--size", "16x16", "--worlds", "4",
                                  "--runs", "1", "--aov", "depth", "--json"});
  ASSERT_EQ(measured.code, 0) << measured.text();
  const json report = json::parse(measured.out);
  double host = 0;
  for (const json& row : report["worlds"]) {
    if (row["pass"] == "host, until submitted") host = row["ms"];
    if (row["pass"] != "all, until done") continue;
    EXPECT_FLOAT_EQ(row["views per second"], 4000 / row["ms"].get<float>());
    EXPECT_LT(host, row["ms"].get<double>());
    EXPECT_GT(host, 0);
  }
}

// All pixels of a camera inside the closed hall see a surface, from which a ray of each other kind starts.
TEST(Bench, MeasuresRays) {
  const Outcome outcome =
      bench({"rays", "builtin:hall,triangles=50k", "--device", "cpu", "--rays", "2k", "--runs", "1", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json report = json::parse(outcome.out);
  std::map<std::string, json> rows;
  for (const json& row : report["rays"]) rows[row["measured"]] = row;
  for (const char* name : {"primary rays", "diffuse rays", "shadow rays", "cast(), host to host"}) {
    ASSERT_TRUE(rows.contains(name)) << name;
    EXPECT_EQ(rows[name]["number"], 2000) << name;
    EXPECT_GT(rows[name]["ms"], 0) << name;
    EXPECT_NEAR(rows[name]["G per second"].get<double>() * rows[name]["ms"].get<double>(), 2e-3, 1e-9) << name;
  }
  EXPECT_GT(rows["triangles of BVHs"]["number"], 1000);
  EXPECT_GT(rows["triangles of BVHs"]["MB"], 0);
  EXPECT_GT(rows["triangles of BVHs"]["ms"], 0);
  EXPECT_GT(rows["cost of BVHs"]["number"], 1);
  EXPECT_EQ(rows["cost of BVHs"]["number"], rows["cost, built on the host"]["number"]);  // a CPU device
}

TEST(Bench, MeasuresRandomTrianglesWithBothRasters) {
  LATELIGHT_SKIP_UNLESS_ALL();
  const Outcome outcome = bench({"raster", "--device", "cpu", "--most", "10k", "--runs", "1", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json report = json::parse(outcome.out);
  EXPECT_NE(report["device"], "");
  ASSERT_EQ(report["raster"].size(), 1u);  // the row for 10k triangles
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

TEST(Bench, MeasuresAFrameWithTheRasterOfTheOptions) {
  for (const char* raster : {"hardware", "compute", "rays"}) {
    const Outcome outcome = bench({"frame", "builtin:boxes", "--device", "cpu", "--size", "64x48", "--runs", "1",
                                   "--shadows", "none", "--raster", raster, "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.text();
    const json rows = json::parse(outcome.out)["frame"];
    ASSERT_GE(rows.size(), 4u);  // visibility, lighting, compose and all
    for (const json& row : rows) {
      EXPECT_EQ(row["raster"], raster);
      EXPECT_GT(row["ms"], 0);
    }
    EXPECT_EQ(rows.back()["pass"], "all");
  }
}

// Some frames have one raster, regardless of --raster: rows of another one would measure the same passes again.
TEST(Bench, NamesTheRasterThatRan) {
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"--lighting", "forward"}, "hardware"},
      {{"--lighting", "forward", "--raster", "compute"}, "hardware"},
      {{"--lens", "equirectangular"}, "compute"},
      {{"--lens", "equirectangular", "--raster", "hardware"}, "compute"},
  };
  for (const auto& [options, raster] : cases)
    for (const char* subject : {"frame", "views"}) {
      std::vector<std::string> arguments{subject, "builtin:boxes", "--device", "cpu",   "--size",
                                         "32x16", "--runs",        "1",        "--json"};
      arguments.insert(arguments.end(), options.begin(), options.end());
      if (subject == std::string_view("views")) arguments.insert(arguments.end(), {"--views", "2"});
      const Outcome outcome = bench(arguments);
      ASSERT_EQ(outcome.code, 0) << outcome.text();
      const json rows = json::parse(outcome.out)[subject];
      ASSERT_FALSE(rows.empty());
      for (const json& row : rows) EXPECT_EQ(row["raster"], raster) << subject << " " << options[1];
    }
}

TEST(Bench, MeasuresManyViews) {
  const Outcome outcome = bench({"views", "builtin:boxes", "--device", "cpu", "--size", "16x16", "--views", "8",
                                 "--runs", "2", "--aov", "depth,id", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json rows = json::parse(outcome.out)["views"];
  int whole = 0;
  for (const json& row : rows)
    if (row["pass"] == "all, until done") {
      EXPECT_FLOAT_EQ(row["views per second"], 8000 / row["ms"].get<float>());
      ++whole;
    }
  EXPECT_EQ(whole, 2);
  EXPECT_THAT(outcome.out, HasSubstr("\"raster cull\""));
}

void expectCeilings(const json& report) {
  EXPECT_GT(report["ceilings"]["copied bytes per second"], 0);
  EXPECT_GT(report["ceilings"]["multiply-adds per second"], 0);
}

// Composing reads 8 bytes per pixel and writes 4. With a transparent background it processes covered tiles only, as
// lighting does, and such passes are not compared with copies.
TEST(Bench, ComparesWholePassesWithCopies) {
  const Outcome outcome = bench({"frame", "builtin:boxes", "--device", "cpu", "--size", "64x48", "--runs", "1",
                                 "--shadows", "none", "--background", "#204060", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json report = json::parse(outcome.out);
  expectCeilings(report);
  const std::map<std::string, double> bytesPerPixel{{"compose", 12}};
  size_t found = 0;
  for (const json& row : report["frame"]) {
    const auto known = bytesPerPixel.find(row["pass"]);
    if (known == bytesPerPixel.end()) {
      EXPECT_TRUE(row.at("MB").is_null()) << row;
      EXPECT_TRUE(row.at("% of copies").is_null()) << row;
      continue;
    }
    ++found;
    const double bytes = known->second * 64 * 48, copied = report["ceilings"]["copied bytes per second"];
    EXPECT_DOUBLE_EQ(row["MB"], 1e-6 * bytes);
    EXPECT_NEAR(row["% of copies"], 100 * bytes / (1e-3 * row["ms"].get<double>() * copied), 1e-6);
  }
  EXPECT_EQ(found, 2u);  // both rasters
}

double meanOfFile(const std::filesystem::path& path) {
  const std::vector<double> values = output::readImage(path).channels.front().values;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

TEST(Bench, MeasuresLightingOverLights) {
  const Outcome outcome = bench({"lights", "builtin:hall,triangles=50k,seed=3", "--device", "cpu", "--size", "64x36",
                                 "--runs", "1", "--shadows", "none", "--lights", "100,1", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json report = json::parse(outcome.out);
  expectCeilings(report);
  const std::pair<const char*, int> order[] = {{"clustered", 1},   {"fullscreen", 1},   {"tiled", 1},
                                               {"clustered", 100}, {"fullscreen", 100}, {"tiled", 100}};
  ASSERT_EQ(report["lights"].size(), std::size(order));
  Folder folder;
  for (size_t i = 0; i < std::size(order); ++i) {
    const json& row = report["lights"][i];
    SCOPED_TRACE(row);
    EXPECT_EQ(row["lighting"], order[i].first);
    EXPECT_EQ(row["lights"], order[i].second);
    EXPECT_GT(row["lighting ms"], 0);
    if (row["lighting"] == "fullscreen" || order[i].second == 1)  // a single light is in no lists
      EXPECT_TRUE(row.at("lists ms").is_null());
    else
      EXPECT_GT(row["lists ms"], 0);
    if (order[i].second == 1 && !latelight::test::runsInFull()) continue;
    const Outcome counted =
        latelight({"render", "builtin:hall,triangles=50k,seed=3,lights=" + std::to_string(order[i].second), "-o",
                   folder.at("{aov}.npy"), "--aov", "lights-tested,lights-used", "--lighting", order[i].first,
                   "--device", "cpu", "--size", "64x36", "--shadows", "none"});
    ASSERT_EQ(counted.code, 0) << counted.text();
    EXPECT_DOUBLE_EQ(row["tested per pixel"], meanOfFile(folder.path() / "lights-tested.npy"));
    EXPECT_DOUBLE_EQ(row["used per pixel"], meanOfFile(folder.path() / "lights-used.npy"));
  }
}

TEST(Bench, MeasuresTheBoundOfLighting) {
  const Outcome outcome = bench({"shade", "builtin:hall,triangles=50k", "--device", "cpu", "--size", "160x90", "--runs",
                                 "1", "--shadows", "none", "--lighting", "tiled", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  const json report = json::parse(outcome.out);
  expectCeilings(report);
  std::set<std::pair<std::string, std::string>> seen;
  for (const json& row : report["shade"]) {
    SCOPED_TRACE(row);
    seen.emplace(row["light"], row["shading"]);
    EXPECT_GT(row["no lights ms"], 0);
    EXPECT_DOUBLE_EQ(row["MB"], 1e-6 * 36 * 160 * 90);  // counts of lights require all tiles
    // a difference of two measured times, so any value is possible on a busy machine
    const double cost = row["ps a light"];
    EXPECT_NEAR(row["G lights/s"].get<double>() * cost, 1000, 1e-6);
    EXPECT_NEAR(row["multiply-adds"], 1e-12 * cost * report["ceilings"]["multiply-adds per second"].get<double>(),
                1e-3);
    EXPECT_EQ(row["lighting"], "tiled");
    EXPECT_NEAR(row["to the bound"].get<double>() * cost, row["ps per used light"], 1e-6 * std::abs(cost) + 1e-6);
  }
  EXPECT_EQ(seen.size(), 9u);  // point, spot and directional lights; ggx, blinn-phong and ggx-compensated
}

TEST(Bench, SaysWhatItCannotDo) {
  const std::pair<std::vector<std::string>, const char*> wrong[] = {
      {{}, "raster, frame, views, worlds, rays, lights or shade"},
      {{"views", "--views", "0"}, "--views"},
      {{"rays", "--rays", "none"}, "--rays requires a number of rays up to 64M"},
      {{"rays", "--rays", "65M"}, "--rays requires a number of rays up to 64M"},
      {{"raster", "--most", "many"}, "--most takes a number"},
      {{"raster", "--most", "9999"}, "--most must be at least 10000"},
      {{"raster", "--runs", "0"}, "--runs"},
      {{"frame", "-o", "x.png"}, "omit --out"},
      {{"frame", "--aov", "depth"}, "omit --aov"},
      {{"views", "--frames", "0-3"}, "omit --frames"},
      {{"frame", "--debug", "sheet"}, "omit --debug"},
      {{"frame", "--dump-graph", "x.dot"}, "omit --dump-graph"},
      {{"views", "--labels", "x.json"}, "omit --labels"},
      {{"worlds", "--no-side-file"}, "omit --no-side-file"},
      {{"rays", "--correspond", "x.npz"}, "omit --correspond"},
      {{"lights", "--pick", "1,1"}, "omit --pick"},
      {{"frame", "builtin:nothing"}, "no built-in scene"},
      {{"lights", "builtin:boxes"}, "a fixed number of lights"},
      {{"lights", "model.glb"}, "built-in scene"},
      {{"lights", "builtin:hall,lights=3"}, "omit lights="},
      {{"lights", "--lights", "1,some"}, "--lights requires comma-separated whole numbers"},
      {{"lights", "--budget", "0"}, "--budget must be above 0 seconds, not 0"},
      {{"lights", "builtin:nothing"}, "no built-in scene"},
      {{"lights", "--lights", "2M"}, "1 to 1000000 lights, not 2000000"},
      {{"lights", "--lighting", "tiled"}, "omit --lighting"},
      {{"lights", "--aa", "ss2"}, "omit --aa"},
      {{"shade", "--aa", "msaa4"}, "omit --aa"},
      {{"shade", "--shading", "ggx"}, "omit --shading"},
      {{"shade", "--lighting", "forward"}, "choose another --lighting"},
      {{"shade", "-o", "x.png"}, "omit --out"},
      {{"shade", "--to-eye", "0,0,0"}, "omit --to-eye"},
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
