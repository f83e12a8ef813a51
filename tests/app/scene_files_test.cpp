// OBJ, PLY and STL files on the command line, and exported scenes.
#include <gmock/gmock.h>
#include <map>
#include <nlohmann/json.hpp>

#include "app/folder.h"
#include "app/process.h"
#include "output/png.h"

namespace latelight::app {
namespace {

using testing::HasSubstr;

// A square of 2 units in the plane z = 0, seen from +z.
constexpr const char* kSquare = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";

Outcome renderSmall(const Folder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "render");
  arguments.insert(arguments.end(), {"--size", "9x9", "--device", "cpu"});
  return latelight({.arguments = std::move(arguments), .folder = folder.path()});
}

TEST(SceneFiles, UnitsAndAxesOfTheCommandLine) {
  const Folder folder;
  folder.write("square.obj", kSquare);
  const auto picked = [&](std::vector<std::string> options) {
    options.insert(options.begin(), "square.obj");
    options.insert(options.end(), {"--pick", "4,4", "--json"});
    const Outcome outcome = renderSmall(folder, options);
    EXPECT_EQ(outcome.code, 0) << outcome.text();
    return outcome.out;
  };
  const auto depth = [&](std::vector<std::string> options) {
    return nlohmann::json::parse(picked(std::move(options)))["picked"][0]["depth"].get<double>();
  };
  EXPECT_NEAR(depth({"--eye", "0,0,5", "--target", "0,0,0"}), 5, 1e-5);
  // One unit is a centimeter, and the square is horizontal.
  EXPECT_NEAR(depth({"--unit", "cm", "--up-axis", "z", "--eye", "0,0,0.05", "--target", "0,0,0", "--up", "0,1,0"}),
              0.05, 1e-7);
}

TEST(SceneFiles, WrongOptionsAndFilesAreReported) {
  const Folder folder;
  folder.write("square.obj", kSquare);
  folder.write("broken.obj", "v 1 2 3\nf 1 2 3\n");
  const auto expect = [&](std::vector<std::string> arguments, int code, const char* says) {
    arguments.insert(arguments.end(), {"-o", "a.png"});
    const Outcome outcome = renderSmall(folder, arguments);
    EXPECT_EQ(outcome.code, code) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr(says));
  };
  expect({"square.obj", "--unit", "yard"}, 2, "mm, cm, m, in or ft");
  expect({"square.obj", "--up-axis", "x"}, 2, "y or z");
  expect({"builtin:boxes", "--unit", "mm"}, 2, "--unit");
  expect({"broken.obj"}, 3, "broken.obj: line 2");
}

TEST(SceneFiles, ExportedScenesAreRenderedAlike) {
  const Folder folder;
  const Outcome exported =
      latelight({.arguments = {"export", "builtin:boxes", "-o", "boxes.glb"}, .folder = folder.path()});
  ASSERT_EQ(exported.code, 0) << exported.text();
  for (const auto& [scene, file] : {std::pair("builtin:boxes", "a.exr"), {"boxes.glb", "b.exr"}}) {
    const Outcome outcome = renderSmall(
        folder, {scene, "-o", file, "--aov", "depth,id,part,material", "--no-side-file", "--orbit", "30,20,8"});
    ASSERT_EQ(outcome.code, 0) << outcome.text();
  }
  const Outcome compared =
      latelight({.arguments = {"compare", "a.exr", "b.exr", "--tolerance", "0"}, .folder = folder.path()});
  EXPECT_EQ(compared.code, 0) << compared.text();
  EXPECT_EQ(latelight({.arguments = {"export", "builtin:boxes", "-o", "boxes.fbx"}, .folder = folder.path()}).code, 2);
  EXPECT_EQ(latelight({.arguments = {"export", "builtin:boxes"}, .folder = folder.path()}).code, 2);
}

// The command that renders a frame is printed for every name of a glTF file.
TEST(SceneFiles, FramesOfJobsAreExportedWithTheirCommand) {
  const Folder folder;
  folder.write("JOB.JSON", R"({"scenes": "builtin:boxes"})");
  for (const std::string out : {"a.glb", "B.GLB"}) {
    const Outcome exported =
        latelight({.arguments = {"export", "--job", "JOB.JSON", "--frame", "0", "-o", out}, .folder = folder.path()});
    EXPECT_EQ(exported.code, 0) << exported.text();
    EXPECT_THAT(exported.out, testing::StartsWith("latelight render " + out + " -o "));
  }
}

// A .obj file is exported with a .mtl file and images, whose names the user does not give.
TEST(SceneFiles, ExportedScenesReplaceNoFileOfTheScene) {
  const Folder folder;
  folder.write("square.obj", std::string("mtllib paint.mtl\nusemtl paint\n") + kSquare);
  folder.write("paint.mtl", "newmtl paint\nKd 1 0 0\nmap_Kd copy_0.png\n");
  const std::vector<std::byte> white(4, std::byte{255});
  folder.write("copy_0.png", output::encodePng(1, 1, 4, 8, white.data(), output::PngLight::Srgb));
  folder.write("job.json", R"({"scenes": "builtin:boxes", "variations": [
                                {"type": "scatter", "objects": [{"file": "square.obj"}], "count": 1,
                                 "min": [-2, -2, 0], "max": [2, 2, 2]}]})");
  std::map<std::string, std::string> before;
  for (const std::string& name : folder.names()) before[name] = folder.read(name);
  const auto expectRejected = [&](std::vector<std::string> arguments, const char* file) {
    arguments.insert(arguments.begin(), "export");
    const Outcome outcome = latelight({.arguments = arguments, .folder = folder.path()});
    EXPECT_EQ(outcome.code, 2) << outcome.text();
    EXPECT_THAT(outcome.err, HasSubstr(std::string("'") + file + "'"));
    std::map<std::string, std::string> after;
    for (const std::string& name : folder.names()) after[name] = folder.read(name);
    EXPECT_EQ(after, before);
  };
  expectRejected({"square.obj", "-o", "square.obj"}, "square.obj");
  expectRejected({"square.obj", "-o", "paint.obj"}, "paint.mtl");
  expectRejected({"square.obj", "-o", "copy.obj"}, "copy_0.png");
  expectRejected({"--job", "job.json", "--frame", "0", "-o", "square.obj"}, "square.obj");
  expectRejected({"--job", "job.json", "--frame", "0", "-o", "paint.obj"}, "paint.mtl");
  const Outcome other = latelight({.arguments = {"export", "square.obj", "-o", "other.obj"}, .folder = folder.path()});
  EXPECT_EQ(other.code, 0) << other.text();
  EXPECT_EQ(folder.read("paint.mtl"), before["paint.mtl"]);
  EXPECT_NE(folder.read("other.mtl"), "");
}

}  // namespace
}  // namespace latelight::app
