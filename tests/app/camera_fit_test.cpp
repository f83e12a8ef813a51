// Cameras of a file in pictures of another aspect ratio. glTF 2.0 (3.10.3) requires viewers to display the camera's
// full frame without cropping or scaling it. A square at depth 4 spans [-0.8, 0.8] x [-0.4, 0.4] of a frame that is
// twice as wide as high: the camera's half extents are 1 and 0.5 at a depth of 1 m, or 4 and 2 m.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "app/folder.h"
#include "app/process.h"
#include "output/read.h"

namespace latelight::app {
namespace {

using nlohmann::json;

void writeScene(const Folder& folder, bool orthographic) {
  const float positions[] = {-3.2f, -1.6f, 0, 3.2f, -1.6f, 0, 3.2f, 1.6f, 0, -3.2f, 1.6f, 0};
  const uint16_t indices[] = {0, 1, 2, 0, 2, 3};
  std::string buffer(reinterpret_cast<const char*>(positions), sizeof(positions));
  buffer.append(reinterpret_cast<const char*>(indices), sizeof(indices));
  folder.write("scene.bin", std::string_view(buffer));
  json camera{{"type", "perspective"},
              {"perspective", {{"yfov", 2 * std::atan(0.5)}, {"aspectRatio", 2}, {"znear", 0.1}}}};
  if (orthographic)
    camera = {{"type", "orthographic"}, {"orthographic", {{"xmag", 4}, {"ymag", 2}, {"znear", 0}, {"zfar", 9}}}};
  const json root{
      {"asset", {{"version", "2.0"}}},
      {"scenes", {{{"nodes", {0, 1}}}}},
      {"nodes", {{{"mesh", 0}}, {{"camera", 0}, {"translation", {0, 0, 4}}}}},
      {"cameras", {camera}},
      {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
      {"buffers", {{{"uri", "scene.bin"}, {"byteLength", buffer.size()}}}},
      {"bufferViews", {{{"buffer", 0}, {"byteLength", 48}}, {{"buffer", 0}, {"byteOffset", 48}, {"byteLength", 12}}}},
      {"accessors",
       {{{"bufferView", 0},
         {"componentType", 5126},
         {"count", 4},
         {"type", "VEC3"},
         {"min", {-3.2, -1.6, 0}},
         {"max", {3.2, 1.6, 0}}},
        {{"bufferView", 1}, {"componentType", 5123}, {"count", 6}, {"type", "SCALAR"}}}}};
  folder.write("scene.gltf", std::string_view(root.dump()));
}

// The number of pixels that the square spans.
struct Span {
  int width = 0, height = 0;
  bool operator==(const Span&) const = default;
  friend void PrintTo(const Span& span, std::ostream* out) { *out << span.width << " x " << span.height; }
};

Span spanIn(const Folder& folder, const std::string& file, int width, int height) {
  const output::ReadImage image = output::readImage(folder.path() / file);
  int left = width, right = -1, top = height, bottom = -1;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      // depth; infinite outside the square
      if (image.channels.at(0).values.at(static_cast<size_t>(y * width + x)) < 100) {
        left = std::min(left, x), right = std::max(right, x);
        top = std::min(top, y), bottom = std::max(bottom, y);
      }
  return {right - left + 1, bottom - top + 1};
}

struct Picture {
  int width, height;
  Span whole, vertical;  // with --camera-fit
};
// In a picture as wide as the frame, the square spans 0.8 of the width. In one as high, it spans 0.8 of the height.
constexpr Picture kPictures[] = {{100, 50, {80, 40}, {80, 40}},
                                 {100, 100, {80, 40}, {100, 80}},
                                 {50, 200, {40, 20}, {50, 160}},
                                 {200, 50, {80, 40}, {80, 40}}};

TEST(CameraFit, ShowsTheWholeFrameOrItsVerticalExtent) {
  for (const bool orthographic : {false, true}) {
    const Folder folder;
    writeScene(folder, orthographic);
    for (const Picture& picture : kPictures) {
      for (const std::string fit : {"whole", "vertical"}) {
        const std::string size = fmt::format("{}x{}", picture.width, picture.height);
        SCOPED_TRACE(size + " " + fit + (orthographic ? " orthographic" : " perspective"));
        std::vector<std::string> arguments{"render", "scene.gltf", "--device", "cpu",   "--size",
                                           size,     "-o",         "a.exr",    "--aov", "depth"};
        if (fit == "vertical") arguments.insert(arguments.end(), {"--camera-fit", fit});
        const Outcome outcome = latelight({.arguments = arguments, .folder = folder.path()});
        ASSERT_EQ(outcome.code, 0) << outcome.text();
        EXPECT_EQ(spanIn(folder, "a.exr", picture.width, picture.height),
                  fit == "whole" ? picture.whole : picture.vertical);
        const json side = json::parse(folder.read("a.json"));
        EXPECT_EQ(side["settings"]["camera-fit"], fit);
        // K projects the square's corner (3.2, -1.6, 4) in the camera frame to the corner of its pixels.
        const json& k = side["camera"]["K"];
        const double w = orthographic ? 1 : 4;
        const double x = (k[0][0].get<double>() * 3.2) / w + k[0][2].get<double>();
        const double y = (k[1][1].get<double>() * -1.6) / w + k[1][2].get<double>();
        const double height = fit == "whole" ? picture.whole.height : picture.vertical.height;  // half the width
        EXPECT_NEAR(x, picture.width / 2.0 + height, 1e-3);
        EXPECT_NEAR(y, picture.height / 2.0 - height / 2, 1e-3);
      }
    }
  }
}

// --fov overrides the file's camera: 90 degrees span 4 m above the axis at a distance of 4 m.
TEST(CameraFit, IsNothingToAFieldOfViewThatIsGiven) {
  const Folder folder;
  writeScene(folder, false);
  const Outcome outcome = latelight({.arguments = {"render", "scene.gltf", "--device", "cpu", "--size", "100x100",
                                                   "--fov", "90", "-o", "a.exr", "--aov", "depth"},
                                     .folder = folder.path()});
  ASSERT_EQ(outcome.code, 0) << outcome.text();
  EXPECT_EQ(spanIn(folder, "a.exr", 100, 100), (Span{80, 40}));
}

TEST(CameraFit, IsThatOfRenderInABatch) {
  const Folder folder;
  writeScene(folder, false);
  for (const std::string fit : {"whole", "vertical"}) {
    const Outcome outcome = latelight(
        {.arguments = {"batch", "--scenes", "scene.gltf", "--devices", "cpu", "--size", "100x100", "--camera-fit", fit,
                       "-o", fit, "--formats", R"({"format": "files", "outputs": ["depth"], "pattern": "{name}.exr"})"},
         .folder = folder.path()});
    ASSERT_EQ(outcome.code, 0) << outcome.text();
    EXPECT_EQ(spanIn(folder, fit + "/000000.exr", 100, 100), (fit == "whole" ? Span{80, 40} : Span{100, 80}));
    EXPECT_EQ(json::parse(folder.read(fit + "/000000.json"))["settings"]["camera-fit"], fit);
  }
}

// --- names ----------------------------------------------------------------------------------------------------------

// Two cameras whose names differ only in their last letter and exceed the maximum length of a file name.
TEST(FileNames, OfLongCamerasAreShortened) {
  const Folder folder;
  writeScene(folder, false);
  json root = json::parse(folder.read("scene.gltf"));
  root["cameras"].push_back(root["cameras"][0]);
  root["nodes"].push_back({{"camera", 1}, {"translation", {0, 0, 5}}});
  root["scenes"][0]["nodes"].push_back(2);
  const std::string name(300, 'c');
  root["cameras"][0]["name"] = name + "0", root["cameras"][1]["name"] = name + "1";
  folder.write("scene.gltf", std::string_view(root.dump()));
  std::set<std::string> files;
  for (const char* camera : {"0", "1", "0"}) {
    const Outcome outcome =
        latelight({.arguments = {"render", "scene.gltf", "--device", "cpu", "--size", "8x8", "--camera", camera, "-o",
                                 "{scene}-{camera}-{aov}.png", "--json", "--aov", "color,depth"},
                   .folder = folder.path()});
    ASSERT_EQ(outcome.code, 0) << outcome.text();
    const json report = json::parse(outcome.out);
    for (const json& file : report.at("files")) files.insert(file.get<std::string>());
  }
  EXPECT_EQ(files.size(), 6u) << "colour, depth and side file of two cameras";
  for (const std::string& file : files) EXPECT_THAT(file, testing::StartsWith("scene-cccccccc"));

  const Outcome set = latelight({.arguments = {"batch", "--scenes", "scene.gltf", "--devices", "cpu", "--size", "8x8",
                                               "--name", "{camera}", "-o", "set"},
                                 .folder = folder.path()});
  ASSERT_EQ(set.code, 0) << set.text();
  EXPECT_EQ(
      std::distance(std::filesystem::directory_iterator(folder.path() / "set"), std::filesystem::directory_iterator()),
      4);  // two pictures, the manifest and the folder of the log
}

TEST(FileNames, WhatIsTooLongAllTheSameIsRefused) {
  const Folder folder;
  writeScene(folder, false);
  json root = json::parse(folder.read("scene.gltf"));
  root["cameras"][0]["name"] = std::string(300, 'c');
  folder.write("scene.gltf", std::string_view(root.dump()));
  const Outcome picture = latelight(
      {.arguments = {"render", "scene.gltf", "--device", "cpu", "--size", "8x8", "-o", "{camera}{camera}{camera}.png"},
       .folder = folder.path()});
  EXPECT_EQ(picture.code, 2) << picture.text();
  EXPECT_THAT(picture.err, testing::HasSubstr("of 304 bytes"));
  const Outcome set = latelight({.arguments = {"batch", "--scenes", "scene.gltf", "--devices", "cpu", "--size", "8x8",
                                               "--name", "{index}{camera}{camera}", "-o", "set"},
                                 .folder = folder.path()});
  EXPECT_EQ(set.code, 2) << set.text();
  EXPECT_THAT(set.err, testing::HasSubstr("206 bytes in one file name"));
}

}  // namespace
}  // namespace latelight::app
