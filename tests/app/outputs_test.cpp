// The files that `render` writes: names and formats, equal values in all formats, the side file, the report and the
// frame graph.
#include "app/process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "app/dot.h"
#include "app/folder.h"
#include "base/hash.h"
#include "models/models.h"
#include "output/aov.h"
#include "output/read.h"
#include "scene/gltf_builder.h"

namespace latelight::app {
namespace {

using namespace models;
using nlohmann::json;
using output::ReadImage;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsSupersetOf;

constexpr uint32_t kWidth = 64, kHeight = 36;

class Outputs : public testing::Test {
 protected:
  // Runs render in the folder, on the CPU, with kWidth x kHeight pixels by default.
  Outcome render(std::vector<std::string> arguments) const {
    if (std::find(arguments.begin(), arguments.end(), "--size") == arguments.end())
      arguments.insert(arguments.begin(), {"--size", "64x36"});
    arguments.insert(arguments.begin(), {"render", "--device", "cpu"});
    const Outcome outcome = latelight({.arguments = arguments, .folder = folder.path()});
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    EXPECT_EQ(outcome.err, "");
    return outcome;
  }
  ReadImage read(const std::string& name) const { return output::readImage(folder.path() / name); }
  json readJson(const std::string& name) const { return json::parse(folder.read(name)); }
  Folder folder;
};

std::string allAovs() {
  std::string list;
  for (const output::AovInfo& aov : output::aovs()) list += (list.empty() ? "" : ",") + std::string(aov.name);
  return list;
}

// The outputs that PNG files can store.
std::vector<output::AovInfo> pngAovs() {
  std::vector<output::AovInfo> some;
  for (const output::AovInfo& aov : output::aovs())
    if (aov.png != output::PngCoding::None) some.push_back(aov);
  return some;
}

const std::vector<double>& values(const ReadImage& image, std::string_view channel) {
  const output::Channel* found = image.find(channel);
  if (!found) throw std::runtime_error("no channel " + std::string(channel));
  return found->values;
}

// The program mentions blended surfaces that data outputs omit, and the option that includes them. Blended surfaces
// whose alpha is 1 everywhere are included.
TEST_F(Outputs, WhatDataLeaveOutIsMentioned) {
  const auto errors = [&](double alpha, const std::vector<std::string>& more) {
    scene::test::GltfBuilder b = scene::test::triangleFile();
    b.add("materials", {{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, alpha}}}}});
    b.primitive()["material"] = 0;
    folder.write("a.glb", b.glb());
    std::vector<std::string> arguments{"render", "a.glb", "-o", "a.npy", "--size", "16x16", "--device", "cpu"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = latelight({.arguments = arguments, .folder = folder.path()});
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    return outcome.err;
  };
  EXPECT_THAT(errors(0.5, {"--aov", "depth"}), HasSubstr("--data-surfaces any includes them"));
  EXPECT_EQ(errors(0.5, {"--aov", "depth", "--data-surfaces", "any"}), "");
  EXPECT_EQ(errors(0.5, {"--aov", "color"}), "");
  EXPECT_EQ(errors(1, {"--aov", "depth"}), "");
}

// --- formats --------------------------------------------------------------------------------------------------------

TEST_F(Outputs, ExrHoldsEveryAovInItsChannels) {
  render({"builtin:boxes", "-o", "a.exr", "--aov", allAovs()});
  EXPECT_THAT(folder.names(), ElementsAre("a.exr", "a.json"));
  const ReadImage image = read("a.exr");
  EXPECT_EQ(image.width, kWidth);
  EXPECT_EQ(image.height, kHeight);
  size_t channels = 0;
  for (const output::AovInfo& aov : output::aovs())
    for (uint32_t c = 0; c < aov.channels; ++c, ++channels)
      EXPECT_NE(image.find(aov.exrChannels[c]), nullptr) << aov.exrChannels[c];
  EXPECT_EQ(image.channels.size(), channels);
}

TEST_F(Outputs, NpyHoldsTheNumbersOfTheExr) {
  render({"builtin:boxes", "-o", "a.exr", "--aov", allAovs()});
  render({"builtin:boxes", "-o", "{scene}/{aov}.npy", "--aov", allAovs()});
  const ReadImage together = read("a.exr");
  for (const output::AovInfo& aov : output::aovs()) {
    SCOPED_TRACE(aov.name);
    const ReadImage image = read("boxes/" + std::string(aov.name) + ".npy");
    ASSERT_EQ(image.channels.size(), aov.channels);
    for (uint32_t c = 0; c < aov.channels; ++c) {
      const std::vector<double>& mine = image.channels[c].values;
      const std::vector<double>& theirs = values(together, aov.exrChannels[c]);
      if (aov.exr != output::ExrType::Half) {
        EXPECT_EQ(mine, theirs);
        continue;
      }
      // Half floats have 11 significant bits.
      for (size_t i = 0; i < mine.size(); ++i) ASSERT_NEAR(mine[i], theirs[i], std::abs(mine[i]) / 2048 + 1e-7) << i;
    }
  }
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "boxes/meta.json"));
}

TEST_F(Outputs, PngHoldsTheNumbersOfTheExrAsItsCodingSays) {
  std::string list;
  for (const output::AovInfo& aov : pngAovs()) list += (list.empty() ? "" : ",") + std::string(aov.name);
  const std::vector<std::string> fromAside{"builtin:boxes", "--orbit", "30,25"};  // some background is visible
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), fromAside.begin(), fromAside.end());
    return more;
  };
  render(with({"-o", "a.png", "--aov", list}));
  render(with({"-o", "a.exr", "--aov", allAovs()}));
  for (const output::AovInfo& aov : pngAovs()) {
    const std::string name = aov.aov == output::Aov::Color ? "a.png" : "a." + std::string(aov.name) + ".png";
    EXPECT_TRUE(std::filesystem::exists(folder.path() / name)) << name;
  }
  const ReadImage exr = read("a.exr"), depth = read("a.depth.png"), normal = read("a.normal.png"),
                  id = read("a.id.png");
  const std::vector<double>&z = values(exr, "Z"), &x = values(exr, "N.X"), &ids = values(exr, "id");
  size_t drawn = 0;
  for (size_t i = 0; i < z.size(); ++i) {
    const bool background = std::isinf(z[i]);
    drawn += !background;
    const double millimetres = background ? 0 : std::min(std::round(z[i] * 1000), 65535.0);
    ASSERT_NEAR(depth.channels[0].values[i] * 65535, millimetres, 1e-6) << i;
    ASSERT_NEAR(values(normal, "R")[i], background ? 0 : x[i] * 0.5 + 0.5, 1.0 / 65535) << i;
    const double bytes = values(id, "R")[i] * 255 + values(id, "G")[i] * 255 * 256 + values(id, "B")[i] * 255 * 65536 +
                         values(id, "A")[i] * 255 * 16777216;
    ASSERT_NEAR(bytes, ids[i], 1e-3) << i;
  }
  EXPECT_GT(drawn, z.size() / 10);
  EXPECT_LT(drawn, z.size() * 9 / 10);
}

// Ids are equal in every format, and the side file resolves them. The nodes of a group have the group's id.
TEST_F(Outputs, IdsPartsAndMaterialsAreTheSameInEveryFormat) {
  folder.write("model.glb", texturedModel());
  const auto with = [](const std::string& out) {
    return std::vector<std::string>{"model.glb", "--id-depth", "0", "-o", out, "--aov", "id,part,material"};
  };
  render(with("a.exr"));
  render(with("a.{aov}.npy"));
  render(with("a.{aov}.png"));
  const json side = readJson("a.json");
  EXPECT_EQ(side["settings"]["id-depth"], "0");
  std::map<std::string, std::set<double>> seen;
  for (const char* name : {"id", "part", "material"}) {
    const std::vector<double> exr = values(read("a.exr"), name);
    EXPECT_EQ(read(std::string("a.") + name + ".npy").channels.front().values, exr);
    const ReadImage png = read(std::string("a.") + name + ".png");
    for (size_t i = 0; i < exr.size(); ++i)
      ASSERT_NEAR(255 * (values(png, "R")[i] + 256 * values(png, "G")[i] + 65536 * values(png, "B")[i] +
                         16777216 * values(png, "A")[i]),
                  exr[i], 1e-3);
    seen[name] = {exr.begin(), exr.end()};
  }
  std::set<double> ids{0}, parts{0}, materials{0};
  for (const auto& [id, entry] : side["ids"].items()) {
    ids.insert(std::stod(id));
    EXPECT_EQ(entry["parent"], 0) << "all are roots";
    for (const json& part : entry["parts"]) parts.insert(part["id"].get<double>());
  }
  for (const auto& [id, material] : side["materials"].items()) materials.insert(std::stod(id));
  EXPECT_THAT(ids, IsSupersetOf(seen["id"]));
  EXPECT_THAT(parts, IsSupersetOf(seen["part"]));
  EXPECT_THAT(materials, IsSupersetOf(seen["material"]));
  EXPECT_GE(seen["part"].size(), seen["id"].size());
  EXPECT_GT(seen["id"].size(), 1u);
}

// The floor's id belongs to the path of its node, and the manifest contains every id in the picture.
TEST_F(Outputs, IdsAreInTheManifest) {
  render({"builtin:boxes", "-o", "a.exr", "--aov", "id"});
  const json manifest = readJson("a.json")["ids"];
  EXPECT_EQ(manifest[std::to_string(hash32("/boxes/floor"))]["node"], "/boxes/floor");
  const ReadImage image = read("a.exr");
  for (const double id : values(image, "id"))
    if (id != 0) {
      ASSERT_TRUE(manifest.contains(std::to_string(static_cast<uint32_t>(id)))) << id;
    }
}

// --- names ----------------------------------------------------------------------------------------------------------

TEST_F(Outputs, PlaceholdersAreFilledInAndTheirFoldersMade) {
  folder.write("model.glb", texturedModel());
  render(
      {"model.glb", "--camera", "1", "--frame", "7", "-o", "{scene}/{camera}/{frame}.{aov}.npy", "--aov", "depth,id"});
  EXPECT_THAT(folder.names(),
              ElementsAre("model.glb", "model/", "model/above_orthographic/", "model/above_orthographic/0007.depth.npy",
                          "model/above_orthographic/0007.id.npy", "model/above_orthographic/0007.meta.json"));
}

TEST_F(Outputs, SeveralAovsGetTheirNamesWhereThePatternHasNone) {
  render({"builtin:boxes", "-o", "a.npy", "--aov", "color,depth"});
  EXPECT_THAT(folder.names(), ElementsAre("a.depth.npy", "a.json", "a.npy"));
}

TEST_F(Outputs, ThereIsNoSideFileForAPictureNorWhereItIsRefused) {
  render({"builtin:boxes", "-o", "a.png"});
  render({"builtin:boxes", "-o", "b.exr", "--aov", "depth", "--no-side-file"});
  EXPECT_THAT(folder.names(), ElementsAre("a.png", "b.exr"));
}

TEST_F(Outputs, DebugNamesAreFilledInToo) {
  render({"builtin:boxes", "-o", "{scene}.{aov}.png", "--debug", "depth"});
  render({"builtin:boxes", "-o", "{scene}.{aov}.png", "--debug", "depth,id"});
  EXPECT_THAT(folder.names(), ElementsAre("boxes.depth.png", "boxes.sheet.png"));
}

TEST_F(Outputs, StandardOutputGetsThePngOfTheFile) {
  render({"builtin:boxes", "-o", "a.png"});
  const Outcome piped = render({"builtin:boxes", "-o", "-"});
  EXPECT_EQ(piped.out, folder.read("a.png"));
  EXPECT_TRUE(piped.out.starts_with("\x89PNG\r\n\x1a\n"));
  EXPECT_THAT(folder.names(), ElementsAre("a.png"));
}

TEST_F(Outputs, AnotherPictureTakesThePlaceOfTheFirst) {
  folder.write("a.png", "an older picture");
  render({"builtin:boxes", "-o", "a.png"});
  EXPECT_EQ(read("a.png").width, kWidth);
}

// --- the side file and the report -----------------------------------------------------------------------------------

TEST_F(Outputs, SideFileSaysHowToReadThePixels) {
  render({"builtin:boxes", "-o", "a.exr", "--aov", "depth,position,id", "--frame", "3", "--layout", "optimized"});
  const json side = readJson("a.json");
  EXPECT_EQ(side["scene"]["source"], "builtin:boxes");
  EXPECT_EQ(side["frame"], 3);
  EXPECT_EQ(side["width"], kWidth);
  EXPECT_EQ(side["height"], kHeight);
  EXPECT_EQ(side["world"]["name"], "gltf");
  EXPECT_EQ(side["settings"]["layout"], "optimized");
  EXPECT_THAT(side["settings"]["raster"], testing::AnyOf("hardware", "compute"));  // the resolved choice, not auto
  EXPECT_EQ(side["aovs"]["depth"]["file"], "a.exr");
  EXPECT_EQ(side["aovs"]["depth"]["unit"], "m");
  EXPECT_THAT(side["device"]["name"].get<std::string>(), HasSubstr("llvmpipe"));
  EXPECT_TRUE(side["versions"].contains("latelight"));
  // 1 / tan(fov / 2) is 2, so the focal length equals the picture's height.
  const json& k = side["camera"]["K"];
  EXPECT_NEAR(k[0][0].get<double>(), kHeight, 1e-4);
  EXPECT_NEAR(k[1][1].get<double>(), kHeight, 1e-4);
  EXPECT_NEAR(k[0][2].get<double>(), kWidth / 2.0, 1e-6);
  EXPECT_NEAR(k[1][2].get<double>(), kHeight / 2.0, 1e-6);
}

// position = pose * (depth * K^-1 * pixel), computed only from the numbers in the files.
TEST_F(Outputs, PixelsPosesAndPositionsAgree) {
  render({"builtin:boxes", "-o", "a.exr", "--aov", "depth,position", "--eye", "3,4,7", "--target", "0,0.5,-1"});
  const json camera = readJson("a.json")["camera"];
  const json &k = camera["K"], &pose = camera["cameraToWorld"];
  const ReadImage image = read("a.exr");
  const std::array<const std::vector<double>*, 3> p{&values(image, "P.X"), &values(image, "P.Y"),
                                                    &values(image, "P.Z")};
  const auto number = [](const json& matrix, int row, int column) { return matrix[row][column].get<double>(); };
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t x = 0; x < kWidth; ++x) {
      const size_t i = y * kWidth + x;
      const double depth = values(image, "Z")[i];
      if (std::isinf(depth)) continue;
      const std::array<double, 3> seen{(x + 0.5 - number(k, 0, 2)) / number(k, 0, 0) * depth,
                                       (y + 0.5 - number(k, 1, 2)) / number(k, 1, 1) * depth, depth};
      for (int axis = 0; axis < 3; ++axis) {
        double expected = number(pose, axis, 3);
        for (int c = 0; c < 3; ++c) expected += number(pose, axis, c) * seen[static_cast<size_t>(c)];
        ASSERT_NEAR((*p[static_cast<size_t>(axis)])[i], expected, 2e-4 * depth) << x << "," << y << " axis " << axis;
      }
    }
}

TEST_F(Outputs, ReportIsJson) {
  const json report = json::parse(render({"builtin:boxes", "-o", "a.exr", "--aov", "color,depth", "--json"}).out);
  EXPECT_EQ(report["files"], (json{"a.exr", "a.json"}));
  EXPECT_EQ(report["scene"], "builtin:boxes");
  EXPECT_EQ(report["triangles"], 96);
  EXPECT_EQ(report["lights"], 1);
  for (const char* phase : {"load", "upload", "render", "write"})
    EXPECT_LE(report["seconds"][phase].get<double>(), report["seconds"]["total"].get<double>()) << phase;
  std::vector<std::string> passes;
  for (const json& pass : report["gpu"]) passes.push_back(pass["pass"]);
  EXPECT_THAT(passes, IsSupersetOf({std::string("geometry compact"), std::string("lighting clustered")}));
}

TEST_F(Outputs, WhatDoesNotLeaveIsNotRendered) {
  const json report = json::parse(render({"builtin:boxes", "-o", "a.png", "--aov", "depth", "--json"}).out);
  EXPECT_THAT(folder.names(), ElementsAre("a.json", "a.png"));
  EXPECT_FALSE(report["gpu"].empty());
  for (const json& pass : report["gpu"])
    EXPECT_THAT(pass["pass"].get<std::string>(), testing::Not(testing::StartsWith("lighting")));
}

TEST_F(Outputs, GraphIsInTheDotLanguage) {
  render({"builtin:boxes", "-o", "a.exr", "--aov", "color,depth", "--dump-graph", "frame.dot"});
  const Dot graph = parseDot(folder.read("frame.dot"));
  EXPECT_TRUE(graph.directed);
  EXPECT_THAT(graph.labels(), IsSupersetOf({std::string("geometry compact"), std::string("lighting clustered")}));
  EXPECT_GT(graph.edges.size(), 4u);
  for (const auto& [from, to] : graph.edges) {
    EXPECT_TRUE(graph.nodes.contains(from)) << from;
    EXPECT_TRUE(graph.nodes.contains(to)) << to;
  }
}

TEST_F(Outputs, GraphOfPickedPixelsIsWritten) {
  render({"builtin:boxes", "--pick", "1,1", "--dump-graph", "pick.dot"});
  const Dot graph = parseDot(folder.read("pick.dot"));
  EXPECT_TRUE(graph.directed);
  EXPECT_GT(graph.edges.size(), 1u);
  EXPECT_THAT(folder.names(), ElementsAre("pick.dot"));
}

// --- picking --------------------------------------------------------------------------------------------------------

// Picking returns the data of that pixel, with names from the manifest. It writes no file and computes no lighting.
TEST_F(Outputs, PickedPixelsAreTheDataOutputs) {
  const std::vector<std::string> scene{"builtin:boxes", "--orbit", "30,25"};  // some background is visible
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), scene.begin(), scene.end());
    return more;
  };
  const json report = json::parse(render(with({"--pick", "32,20", "--pick", "0,0", "--json"})).out);
  EXPECT_THAT(folder.names(), testing::IsEmpty());
  for (const json& pass : report["gpu"])
    EXPECT_THAT(pass["pass"].get<std::string>(), testing::Not(testing::StartsWith("lighting")));
  render(with({"-o", "a.exr", "--aov", "depth,position,normal,id,part"}));
  const ReadImage image = read("a.exr");
  const json &first = report["picked"][0], &second = report["picked"][1];
  constexpr size_t kAt = 20 * kWidth + 32;
  EXPECT_EQ(first["pixel"], (json{32, 20}));
  EXPECT_EQ(first["id"].get<double>(), values(image, "id")[kAt]);
  EXPECT_EQ(first["part"].get<double>(), values(image, "part")[kAt]);
  EXPECT_EQ(first["depth"].get<float>(), values(image, "Z")[kAt]);
  EXPECT_EQ(first["position"][1].get<float>(), values(image, "P.Y")[kAt]);
  EXPECT_EQ(first["normal"][2].get<float>(), values(image, "N.Z")[kAt]);
  EXPECT_EQ(readJson("a.json")["ids"][std::to_string(first["id"].get<uint32_t>())]["node"], first["node"]);
  EXPECT_EQ(second, (json{{"pixel", {0, 0}}, {"id", 0}}));

  const Outcome text = render(with({"--pick", "32,20", "--pick", "0,0", "-o", "b.png"}));
  EXPECT_THAT(text.out, HasSubstr("pixel 32,20\n  id         " + first["id"].dump() + "\n  part       " +
                                  first["part"].dump() + "\n  node       " + first["node"].get<std::string>()));
  EXPECT_THAT(text.out, HasSubstr("pixel 0,0: background\n"));
  EXPECT_EQ(read("b.png").width, kWidth);
}

// --- reproducibility ------------------------------------------------------------------------------------------------

// lavapipe stores every compiled shader in a file of its own. There must not be one for nearly every material.
TEST_F(Outputs, ManyMaterialsNeedFewShaders) {
  folder.write("many.glb", manyMaterialsModel());
  const std::string cache = folder.path() / "cache";
  const Outcome outcome =
      latelight({.arguments = {"render", "many.glb", "-o", "a.png", "--size", "64x36", "--device", "cpu"},
                 .environment = {{"MESA_SHADER_CACHE_DIR", cache}},
                 .folder = folder.path()});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  size_t shaders = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(cache)) shaders += entry.is_regular_file();
  EXPECT_GE(shaders, 5u) << "it keeps them elsewhere";
  EXPECT_LE(shaders, 40u);
}

TEST_F(Outputs, TheSameCommandTwiceGivesTheSameBytes) {
  folder.write("model.glb", punctualModel());
  for (const char* run : {"1", "2"}) {
    std::filesystem::create_directory(folder.path() / run);
    const auto out = [&](const char* name) { return std::string(run) + "/" + name; };
    render({"model.glb", "-o", out("a.png"), "--hdri", "studio"});
    render({"model.glb", "-o", out("a.exr"), "--aov", allAovs()});
    render({"model.glb", "-o", out("{aov}.npy"), "--aov", allAovs()});
    render({"model.glb", "-o", out("sheet.png"), "--debug", "sheet"});
    render({"model.glb", "-o", out("four.png"), "--aa", "msaa4"});
    render({"model.glb", "-o", out("smooth.png"), "--aa", "ss2", "--dump-graph", out("frame.dot")});
  }
  size_t compared = 0;
  for (const std::string& name : folder.names()) {
    if (!name.starts_with("1/") || name == "1/") continue;
    ++compared;
    EXPECT_EQ(hash32(folder.read(name)), hash32(folder.read("2/" + name.substr(2)))) << name;
  }
  EXPECT_GE(compared, 5 + output::aovs().size());
}

// The maximum number of threads, and one.
TEST_F(Outputs, ThreadsDoNotChangeTheBytes) {
  folder.write("model.glb", texturedModel());
  render({"model.glb", "-o", "many.png"});
  const Outcome one =
      latelight({.arguments = {"render", "model.glb", "-o", "one.png", "--size", "64x36", "--device", "cpu"},
                 .environment = {{"LATELIGHT_THREADS", "1"}, {"LATELIGHT_NO_CACHE", "1"}},
                 .folder = folder.path()});
  EXPECT_EQ(one.code, 0) << one.text();
  EXPECT_TRUE(folder.read("many.png") == folder.read("one.png"));
}

// --- debug pictures and comparisons ---------------------------------------------------------------------------------

TEST_F(Outputs, DebugPicturesAreOpaque) {
  render({"builtin:boxes", "-o", "depth.png", "--debug", "depth"});
  const ReadImage depth = read("depth.png");
  EXPECT_EQ(depth.width, kWidth);
  EXPECT_THAT(values(depth, "A"), testing::Each(1.0));
  render({"builtin:boxes", "-o", "sheet.png", "--debug", "sheet"});
  const ReadImage sheet = read("sheet.png");
  // The picture has four columns; 15 AOVs need four rows of pictures and labels.
  EXPECT_GE(sheet.width, 4 * kWidth);
  EXPECT_GE(sheet.height, 4 * kHeight);
  EXPECT_THAT(values(sheet, "A"), testing::Each(1.0));
}

// The debug picture shows the targets of the selected layout, as listed, whatever the anti-aliasing.
TEST_F(Outputs, DebugTargetsAreThoseOfTheLayout) {
  render({"builtin:boxes", "-o", "{scene}.{aov}.png", "--debug", "targets", "--layout", "blog"});
  const ReadImage blog = read("boxes.targets.png");
  EXPECT_THAT(values(blog, "A"), testing::Each(1.0));
  // Nine pictures (ids, three pairs of color and alpha, normals, light and depth) in rows of four.
  EXPECT_GE(blog.width, 4 * kWidth);
  EXPECT_GE(blog.height, 3 * kHeight);
  render({"builtin:boxes", "-o", "smooth.png", "--debug", "targets", "--layout", "blog", "--aa", "ss4"});
  EXPECT_TRUE(folder.read("smooth.png") == folder.read("boxes.targets.png"));
  render({"builtin:boxes", "-o", "engine.png", "--debug", "targets", "--layout", "engine"});
  EXPECT_LT(read("engine.png").height, blog.height);
  render({"builtin:boxes", "-o", "xyz.png", "--debug", "targets", "--layout", "optimized", "--normals", "xyz"});
  render({"builtin:boxes", "-o", "octahedral.png", "--debug", "targets", "--layout", "optimized"});
  EXPECT_FALSE(folder.read("xyz.png") == folder.read("octahedral.png"));
}

TEST_F(Outputs, CompareExitsByLikeness) {
  render({"builtin:boxes", "-o", "a.png"});
  render({"builtin:boxes", "-o", "again.png"});
  render({"builtin:boxes", "-o", "brighter.png", "--exposure", "1"});
  const auto compare = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "compare");
    return latelight({.arguments = arguments, .folder = folder.path()});
  };
  EXPECT_EQ(compare({"a.png", "again.png"}).code, 0);
  const Outcome apart = compare({"a.png", "brighter.png", "--json", "--diff", "difference.png"});
  EXPECT_EQ(apart.code, 1);
  EXPECT_EQ(apart.err, "");
  const json report = json::parse(apart.out);
  EXPECT_EQ(report["alike"], false);
  EXPECT_EQ(report["outputs"]["color"]["pixels"], kWidth * kHeight);
  EXPECT_GT(report["outputs"]["color"]["share"].get<double>(), 0.5);
  EXPECT_EQ(read("difference.png").width, kWidth);
  EXPECT_EQ(compare({"a.png", "brighter.png", "--tolerance", "1"}).code, 0);
}

TEST_F(Outputs, CompareRefusesOtherSizes) {
  render({"builtin:boxes", "-o", "a.png"});
  render({"builtin:boxes", "-o", "b.png", "--size", "32x18"});
  const Outcome outcome = latelight({.arguments = {"compare", "a.png", "b.png"}, .folder = folder.path()});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("32x18"));
}

}  // namespace
}  // namespace latelight::app
