// Every invalid use ends with its exit code and one sentence on standard error, and writes no file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>

#include "app/folder.h"
#include "app/process.h"
#include "models/models.h"

namespace latelight::app {
namespace {

using namespace models;
using testing::HasSubstr;

constexpr int kUsage = 2, kBadInput = 3, kNoDevice = 4;

struct WrongUse {
  const char* name;
  std::vector<std::string> arguments;
  int code;
  std::vector<std::string> says;  // parts of the message
  std::map<std::string, std::string> environment = {};
};

// Printed if a test fails.
std::ostream& operator<<(std::ostream& out, const WrongUse& use) {
  for (const std::string& argument : use.arguments) out << '\'' << argument << "' ";
  return out;
}

// Expects "latelight: <sentence>" and no other output.
void expectOneSentence(const Outcome& outcome) {
  EXPECT_TRUE(outcome.err.starts_with("latelight: ")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_TRUE(outcome.err.ends_with('\n'));
  EXPECT_GT(outcome.err.size(), 30u) << outcome.err;
  EXPECT_EQ(outcome.out, "");
}

// Returns the names of the files in the folder in which the program runs.
void fill(const Folder& folder) {
  std::filesystem::create_directory(folder.path() / "folder.png");
  std::filesystem::create_directory(folder.path() / "scene.gltf");
  std::filesystem::create_symlink("/dev/full", folder.path() / "full.png");
  std::filesystem::create_symlink("nowhere", folder.path() / "lost");
  folder.write("noise.glb", "this is not a scene");
  folder.write("empty.gltf", "");
  folder.write("half.gltf", R"({"asset": {"version": "2.0"}, "meshes": [)");
  folder.write("old.gltf", R"({"asset": {"version": "1.0"}})");
  folder.write("needs.gltf", R"({"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_subsurface"],
                                 "extensionsRequired": ["KHR_materials_subsurface"]})");
  folder.write("lost.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "lost.bin", "byteLength": 12}]})");
  folder.write("job.json", R"({"scenes": "builtin:boxes", "repeat": 2})");
  folder.write("job.glb", R"({"scenes": "builtin:boxes"})");
  folder.write("lost.json", R"({"scenes": "lost.gltf", "output": "set"})");
  folder.write("second.json", R"({"scenes": ["builtin:boxes", "lost.gltf"], "repeat": 2})");
  folder.write("broken.hdr", "#?RADIANCE\n");
  folder.write("two.png", "not a picture");
  const Bytes good = texturedModel();
  folder.write("good.glb", good);
  folder.write("cut.glb", std::span(good).first(good.size() / 2));
}

class WrongUseTest : public testing::TestWithParam<WrongUse> {};

TEST_P(WrongUseTest, EndsWithItsCodeAndOneSentence) {
  Folder folder;
  fill(folder);
  const std::vector<std::string> before = folder.names();
  const Outcome outcome =
      latelight({.arguments = GetParam().arguments, .environment = GetParam().environment, .folder = folder.path()});
  EXPECT_EQ(outcome.code, GetParam().code) << outcome.text();
  expectOneSentence(outcome);
  for (const std::string& part : GetParam().says) EXPECT_THAT(outcome.err, HasSubstr(part));
  EXPECT_EQ(folder.names(), before);
}

std::string wrongUseName(const testing::TestParamInfo<WrongUse>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(
    Commands, WrongUseTest,
    testing::Values(
        WrongUse{"Nothing", {}, kUsage, {"no command", "render, batch, view"}},
        WrongUse{"UnknownCommand", {"paint"}, kUsage, {"paint", "render"}},
        WrongUse{"UnknownOption", {"render", "-o", "a.png", "--colour", "red"}, kUsage, {"--colour"}},
        WrongUse{"UnknownOptionBeforeTheCommand", {"--colour", "render", "-o", "a.png"}, kUsage, {"--colour"}},
        WrongUse{
            "UnknownArguments", {"render", "a.glb", "b.glb", "--colour", "c.glb"}, kUsage, {"b.glb --colour c.glb"}},
        WrongUse{"NoOutput", {"render", "builtin:boxes"}, kUsage, {"--out"}},
        WrongUse{"ExportJobWithoutFrame", {"export", "--job", "job.json", "-o", "a.glb"}, kUsage, {"--job", "--frame"}},
        WrongUse{"ExportFrameWithoutJob", {"export", "--frame", "0", "-o", "a.glb"}, kUsage, {"--job", "--frame"}},
        WrongUse{"ExportJobAndScene",
                 {"export", "builtin:boxes", "--job", "job.json", "--frame", "0", "-o", "a.glb"},
                 kUsage,
                 {"--job", "omit builtin:boxes"}},
        WrongUse{"ExportJobAndLoadOption",
                 {"export", "--job", "job.json", "--frame", "0", "--variant", "red", "-o", "a.glb"},
                 kUsage,
                 {"omit --variant"}},
        WrongUse{"ExportNoSuchFrame",
                 {"export", "--job", "job.json", "--frame", "2", "-o", "a.glb"},
                 kUsage,
                 {"the job has 2 frames", "no frame 2"}},
        WrongUse{"ExportNegativeFrame",
                 {"export", "--job", "job.json", "--frame=-1", "-o", "a.glb"},
                 kUsage,
                 {"--frame", "not \"-1\""}},
        WrongUse{"ExportFrameBeyondIntegers",
                 {"export", "--job", "job.json", "--frame", "99999999999999999999", "-o", "a.glb"},
                 kUsage,
                 {"--frame", "not \"99999999999999999999\""}},
        WrongUse{"ExportNoJob", {"export", "--job", "no.json", "--frame", "0", "-o", "a.glb"}, kBadInput, {"no.json"}},
        WrongUse{
            "ExportOverTheJob", {"export", "--job", "job.glb", "--frame", "0", "-o", "job.glb"}, kUsage, {"job.glb"}},
        WrongUse{"ExportBrokenSecondScene",
                 {"export", "--job", "second.json", "--frame", "3", "-o", "a.glb"},
                 kBadInput,
                 {"lost.gltf", "lost.bin"}},
        WrongUse{"ExportBrokenScene",
                 {"export", "--job", "lost.json", "--frame", "0", "-o", "a.glb"},
                 kBadInput,
                 {"lost.gltf", "lost.bin"}},
        WrongUse{
            "ViewWithLabels", {"view", "--labels", "l.json"}, kUsage, {"view is interactive", "omit it", "--labels"}},
        WrongUse{"ServeAtNoPort",
                 {"serve", "builtin:boxes", "--port", "70000"},
                 kUsage,
                 {"--port", "70000 not in range 0 to 65535 (see latelight serve --help)"}},
        WrongUse{"ServeAtANegativePort",
                 {"serve", "builtin:boxes", "--port", "-1"},
                 kUsage,
                 {"--port", "-1 not in range 0 to 65535 (see latelight serve --help)"}},
        WrongUse{"ServeAtAHexadecimalPort",
                 {"serve", "builtin:boxes", "--port", "0x2328"},
                 kUsage,
                 {"--port takes a whole number of at least 0, not \"0x2328\" (see latelight serve --help)"}},
        WrongUse{"ServeAtAPortWithABlank", {"serve", "builtin:boxes", "--port", " 9000"}, kUsage, {"not \" 9000\""}},
        WrongUse{"ServeAtNoPortAtAll", {"serve", "builtin:boxes", "--port="}, kUsage, {"--port"}},
        WrongUse{"CompareHexadecimalShare", {"compare", "a.png", "b.png", "--share", "0x1"}, kUsage, {"\"0x1\""}},
        WrongUse{"ComparePerceptual", {"compare", "a.png", "b.png", "--flip", "nan"}, kUsage, {"--flip", "\"nan\""}},
        WrongUse{"StudyForever", {"study", "lights", "--budget", "inf"}, kUsage, {"--budget takes a number", "inf"}},
        WrongUse{"StudyOfDepthInTheSky",
                 {"study", "depth", "--hdri", "nosuchfile"},
                 kUsage,
                 {"the study depth does not use --hdri: omit it"}},
        WrongUse{"StudyOfDepthOfASeed", {"study", "depth", "--seed", "3"}, kUsage, {"omit", "--seed"}},
        WrongUse{"StudyOfDepthOfBits", {"study", "depth", "--bits", "8"}, kUsage, {"omit", "--bits"}},
        WrongUse{"StudyOfNormalsOfLights", {"study", "normals", "--lights", "3"}, kUsage, {"omit", "--lights"}},
        WrongUse{"StudyOfNormalsOfABudget", {"study", "normals", "--budget", "5"}, kUsage, {"omit", "--budget"}},
        WrongUse{"StudyOfPositionOfSizes", {"study", "position", "--sizes", "64x64"}, kUsage, {"omit", "--sizes"}},
        WrongUse{"StudyOfLightsOfSamples", {"study", "lights", "--samples", "4000"}, kUsage, {"omit", "--samples"}},
        WrongUse{
            "StudyOfAccuracyOfTriangles", {"study", "accuracy", "--triangles", "50k"}, kUsage, {"omit", "--triangles"}},
        WrongUse{"StudyOfNoNumber",
                 {"study", "normals", "--samples", "many"},
                 kUsage,
                 {"--samples takes a whole number of at least 0, not \"many\" (see latelight study --help)"}},
        WrongUse{"StudyOfNoTime",
                 {"study", "lights", "--budget", "long"},
                 kUsage,
                 {"--budget takes a number, not \"long\" (see latelight study --help)"}},
        WrongUse{"BenchOfNoTime",
                 {"bench", "lights", "builtin:boxes", "--budget", "long"},
                 kUsage,
                 {"--budget takes a number, not \"long\" (see latelight bench lights --help)"}},
        WrongUse{"ServeWithLabels", {"serve", "--labels", "l.json"}, kUsage, {"serve is interactive", "--labels"}},
        WrongUse{"ServeEyeInTarget",
                 {"serve", "builtin:boxes", "--device", "cpu", "--port", "0", "--eye", "1,2,3", "--target", "1,2,3"},
                 kUsage,
                 {"eye and target are both (1, 2, 3)"}},
        WrongUse{"ServeUnderNoName",
                 {"serve", "builtin:boxes", "--device", "cpu", "--port", "0", "--host-name", "a b/c"},
                 kUsage,
                 {"--host-name", "\"a b/c\""}},
        WrongUse{"ServeWithKeypoints", {"serve", "--keypoints", "[]"}, kUsage, {"does not support --keypoints"}},
        WrongUse{"ServeWithCorrespondence", {"serve", "--correspond", "c.npz"}, kUsage, {"--correspond"}},
        WrongUse{"ServeWithASecondTime", {"serve", "--to-time", "1"}, kUsage, {"does not support --to-time"}},
        WrongUse{"ReportWithLabels", {"report", "-o", "a.html", "--labels", "l.json"}, kUsage, {"omit --labels"}},
        WrongUse{
            "ReportWithASecondCamera", {"report", "-o", "a.html", "--to-camera", "1"}, kUsage, {"omit --to-camera"}},
        WrongUse{"PickOutside",
                 {"render", "builtin:boxes", "--size", "64x36", "--pick", "3,4", "--pick", "64,0"},
                 kUsage,
                 {"64,0", "64x36"}},
        WrongUse{"UnknownIdNode",
                 {"render", "builtin:boxes", "-o", "a.png", "--id-nodes", "floor,ceiling"},
                 kUsage,
                 {"builtin:boxes", "\"ceiling\""}},
        WrongUse{"IdsByDepthAndByNodes",
                 {"render", "builtin:boxes", "-o", "a.png", "--id-nodes", "floor", "--id-depth", "1"},
                 kUsage,
                 {"--id-depth", "--id-nodes"}},
        WrongUse{"NoIdDepth", {"render", "builtin:boxes", "-o", "a.png", "--id-depth", "deep"}, kUsage, {"--id-depth"}},
        WrongUse{"PickNoPixel", {"render", "builtin:boxes", "--pick", "3;4"}, kUsage, {"--pick", "3;4"}},
        WrongUse{"PickNegative", {"render", "builtin:boxes", "--pick=-1,4"}, kUsage, {"--pick", "-1,4"}},
        WrongUse{"PickAndDataWithoutOutput", {"render", "--pick", "1,1", "--aov", "depth"}, kUsage, {"--out"}},
        WrongUse{"PickAndPictureToStandardOutput", {"render", "--pick", "1,1", "-o", "-"}, kUsage, {"--pick"}},
        WrongUse{"UnknownTransparency",
                 {"render", "-o", "a.png", "--transparency", "foggy"},
                 kUsage,
                 {"foggy", "exact", "weighted"}},
        WrongUse{"UnknownDataSurfaces", {"render", "-o", "a.png", "--data-surfaces", "all"}, kUsage, {"all", "opaque"}},
        WrongUse{"OptionWithoutValue", {"render", "-o", "a.png", "--fov"}, kUsage, {"--fov"}},
        WrongUse{
            "TwoScenes", {"render", "builtin:boxes", "builtin:spheres", "-o", "a.png"}, kUsage, {"builtin:spheres"}},
        WrongUse{"UnknownStudy", {"study", "fruit"}, kUsage, {"fruit", "normals", "position"}},
        WrongUse{"StudyOfTooFewBits", {"study", "normals", "--bits", "7"}, kUsage, {"--bits", "8 to 16"}},
        WrongUse{"StudyOfTooFewSamples", {"study", "depth", "--samples", "3"}, kUsage, {"--samples", "1000"}},
        WrongUse{"StudyOfNoNumberOfLights", {"study", "lights", "--lights", "1,many"}, kUsage, {"--lights", "1,many"}},
        WrongUse{"StudyOfTooFewTriangles",
                 {"study", "lights", "--device", "cpu", "--triangles", "9k"},
                 kUsage,
                 {"10000", "9000"}},
        WrongUse{"StudyWithoutTime", {"study", "lights", "--budget", "0"}, kUsage, {"--budget"}},
        WrongUse{"StudyOfNoSize", {"study", "lights", "--sizes", "wide"}, kUsage, {"--sizes", "wide"}},
        WrongUse{"StudyIntoAFile", {"study", "depth", "-o", "two.png"}, kUsage, {"two.png", "folder"}},
        WrongUse{"StudyIntoALostLink", {"study", "depth", "-o", "lost"}, kUsage, {"lost", "File exists"}},
        WrongUse{"StudyIntoNoFolder", {"study", "depth", "-o", "no/where"}, kUsage, {"no"}},
        WrongUse{"StudyOnNoDevice", {"study", "depth", "-o", "new", "--device", "abacus"}, kNoDevice, {"abacus"}},
        WrongUse{"UnknownShadows",
                 {"render", "builtin:boxes", "-o", "a.png", "--shadows", "stencil"},
                 kUsage,
                 {"stencil", "rgba8-classic"}},
        WrongUse{"UnknownShadowFilter",
                 {"render", "builtin:boxes", "-o", "a.png", "--shadow-filter", "vsm"},
                 kUsage,
                 {"vsm", "pcss"}},
        WrongUse{"ShadowsOfNoLight",
                 {"render", "builtin:boxes", "-o", "a.png", "--device", "cpu", "--shadow-lights", "moon"},
                 kUsage,
                 {"moon", "auto"}},
        WrongUse{"ShadowAtlasOfNothing",
                 {"render", "builtin:boxes", "-o", "a.png", "--shadow-atlas", "0"},
                 kUsage,
                 {"atlas", "256"}},
        WrongUse{"LightOfNoSize",
                 {"render", "builtin:boxes", "-o", "a.png", "--light-size", "nan"},
                 kUsage,
                 {"--light-size", "meters", "nan"}},
        WrongUse{"SunWithoutElevation",
                 {"render", "builtin:boxes", "-o", "a.png", "--sun", "30"},
                 kUsage,
                 {"--sun", "30,40"}},
        WrongUse{"SunOfNegativeLight",
                 {"render", "builtin:boxes", "-o", "a.png", "--sun", "30,40,-1"},
                 kUsage,
                 {"sun", "-1"}},
        WrongUse{"UnknownList", {"list", "fruit"}, kUsage, {"fruit", "layouts", "tonemaps"}},
        WrongUse{"ListSize", {"list", "layouts", "--size", "0x0"}, kUsage, {"0x0"}},
        WrongUse{"ListSamples", {"list", "layouts", "--samples", "0"}, kUsage, {"0 samples"}},
        WrongUse{"CompareOne", {"compare", "a.png"}, kUsage, {"B"}},
        WrongUse{"CompareMissing", {"compare", "a.png", "b.png"}, kBadInput, {"a.png"}},
        WrongUse{"CompareBroken", {"compare", "two.png", "two.png"}, kBadInput, {"two.png"}},
        WrongUse{"CompareTolerance", {"compare", "two.png", "two.png", "--tolerance", "nan"}, kUsage, {"--tolerance"}},
        WrongUse{"CompareShare", {"compare", "two.png", "two.png", "--share", "nan"}, kUsage, {"--share"}},
        WrongUse{"ComparePixelsPerDegree", {"compare", "two.png", "two.png", "--ppd", "nan"}, kUsage, {"--ppd"}}),
    wrongUseName);

// The arguments `render builtin:boxes -o a.png`, and the invalid ones after them.
WrongUse option(const char* name, std::vector<std::string> wrong, std::vector<std::string> says) {
  std::vector<std::string> arguments{"render", "builtin:boxes", "-o", "a.png"};
  arguments.insert(arguments.end(), wrong.begin(), wrong.end());
  return {name, std::move(arguments), kUsage, std::move(says)};
}

INSTANTIATE_TEST_SUITE_P(
    Sizes, WrongUseTest,
    testing::Values(option("SizeZero", {"--size", "0x0"}, {"0x0", "16384"}),
                    option("SizeHuge", {"--size", "100000x100000"}, {"100000x100000", "16384"}),
                    option("SizeBeyondIntegers", {"--size", "99999999999x1"}, {"99999999999x1", "1280x720"}),
                    option("SizeText", {"--size", "big"}, {"\"big\"", "1280x720"}),
                    option("SizeNegative", {"--size=-64x36"}, {"-64x36"}),
                    option("SizeNothing", {"--size", ""}, {"--size"}),
                    option("SamplesUnknown", {"--aa", "smaa"}, {"smaa", "msaa4", "ss4"}),
                    option("BloomNan", {"--bloom", "nan"}, {"bloom", "nan"}),
                    option("AoRadiusZero", {"--ao-radius", "0"}, {"--ao-radius", "above 0 meters"}),
                    option("FogNegative", {"--fog=-1"}, {"fog", "-1"}),
                    option("FogColor", {"--fog-color", "red"}, {"--fog-color", "red"}),
                    option("SamplesNone", {"--aa", "ss0"}, {"ss0"}),
                    option("SamplesMany", {"--aa", "ss17"}, {"ss17", "ss16"}),
                    option("Frame", {"--frame=-1"}, {"--frame"})),
    wrongUseName);

INSTANTIATE_TEST_SUITE_P(
    Cameras, WrongUseTest,
    testing::Values(option("FovZero", {"--fov", "0"}, {"--fov", "0 and 180"}),
                    option("FovFlat", {"--fov", "180"}, {"--fov", "0 and 180"}),
                    option("FovTooNarrow", {"--fov", "1e-308"}, {"--fov", "1e-308"}),
                    option("FovTooWide", {"--fov", "179.9999999"}, {"--fov", "0 and 180"}),
                    option("FovNan", {"--fov", "nan"}, {"--fov", "nan"}),
                    option("FovText", {"--fov", "wide"}, {"--fov", "wide"}),
                    option("LensUnknown", {"--lens", "round"}, {"--lens", "fisheye", "\"round\""}),
                    option("LensShort", {"--lens", "opencv:1,2,3"}, {"--lens", "fx,fy,cx,cy", "3 numbers"}),
                    option("LensText", {"--lens", "fisheye:1,1,a,2"}, {"--lens", "\"a\""}),
                    option("LensFlat", {"--lens", "pinhole:0,1,2,2"}, {"focal", "0"}),
                    option("LensOfNumbers", {"--lens", "equirectangular:1"}, {"--lens", "no numbers"}),
                    option("LensNotSixSquares", {"--lens", "cubemap", "--size", "64x64"}, {"six", "64x64"}),
                    option("LensAndFov", {"--lens", "equirectangular", "--fov", "40"}, {"--lens", "--fov"}),
                    option("LensAndRaster", {"--lens", "equirectangular", "--aov", "raster-classes"}, {"raster"}),
                    option("LensAndForward", {"--lens", "equirectangular", "--lighting", "forward"}, {"forward"}),
                    option("OrbitOne", {"--orbit", "30"}, {"--orbit", "30,20"}),
                    option("OrbitNan", {"--orbit", "nan,0"}, {"--orbit", "nan,0"}),
                    option("OrbitText", {"--orbit", "left"}, {"--orbit", "left"}),
                    option("OrbitDistance", {"--orbit", "0,0,-1"}, {"-1"}),
                    option("CameraUnknown", {"--camera", "back"}, {"\"back\"", "\"main\""}),
                    option("CameraNumber", {"--camera", "7"}, {"\"7\"", "\"main\""}),
                    option("EyeAlone", {"--eye", "0,0,0"}, {"--eye", "--target"}),
                    option("TargetAlone", {"--target", "0,0,0"}, {"--eye", "--target"}),
                    option("EyeNan", {"--eye", "0,nan,0", "--target", "0,0,1"}, {"--eye", "0,nan,0"}),
                    option("EyeInTarget", {"--eye", "1,2,3", "--target", "1,2,3"}, {"(1, 2, 3)"}),
                    option("EyeTwo", {"--eye", "1,2", "--target", "1,2,3"}, {"--eye", "x,y,z"}),
                    option("UpAlone", {"--up", "0,1,0"}, {"--up", "--eye"}),
                    option("UpAlongTheView", {"--eye", "0,0,0", "--target", "0,0,5", "--up", "0,0,1"}, {"up"}),
                    option("TwoCameras", {"--camera", "main", "--orbit", "0,0"}, {"--camera", "--orbit"}),
                    WrongUse{"CameraOfMany",
                             {"render", "good.glb", "-o", "a.png", "--camera", "side"},
                             kUsage,
                             {"\"side\"", "\"front\"", "\"above/orthographic\""}}),
    wrongUseName);

INSTANTIATE_TEST_SUITE_P(
    Times, WrongUseTest,
    testing::Values(option("TimeNan", {"--time", "nan"}, {"--time", "nan"}),
                    option("TimeEndless", {"--time", "inf"}, {"--time", "inf"}),
                    option("TimeText", {"--time", "noon"}, {"--time", "noon"}),
                    option("FpsZero", {"--time", "1", "--fps", "0"}, {"--fps", "0"}),
                    option("FpsNan", {"--frames", "0-1", "--fps", "nan"}, {"--fps", "nan"}),
                    option("FramesBackwards", {"--frames", "5-2"}, {"--frames", "5-2", "0-47"}),
                    option("FramesText", {"--frames", "a-b"}, {"--frames", "a-b", "0-47"}),
                    option("FramesBeyondIntegers", {"--frames", "0-99999999999"}, {"--frames", "0-47"}),
                    option("FramesTooMany", {"--frames", "0-4000000000"}, {"--frames", "1000000"}),
                    option("FramesIntoOneFile", {"--frames", "0-1"}, {"{frame}"}),
                    option("FramesAndTime", {"--frames", "0-1", "--time", "1"}, {"--frames", "--time"}),
                    option("FramesAndFrame", {"--frames", "0", "--frame", "1"}, {"--frames", "--frame"}),
                    option("TurnNan", {"--turn", "nan"}, {"--turn", "nan"}),
                    option("AnimationWithoutTime", {"--animation", "walk"}, {"--animation", "--time"}),
                    option("AnimationUnknown", {"--time", "1", "--animation", "walk"}, {"\"walk\"", "it has none"}),
                    option("AllOfNoAnimations", {"--time", "1", "--animation", "all"}, {"has no animation"})),
    wrongUseName);

INSTANTIATE_TEST_SUITE_P(
    Looks, WrongUseTest,
    testing::Values(option("Layout", {"--layout", "fat"}, {"\"fat\"", "thin", "optimized"}),
                    option("Normals", {"--normals", "fat"}, {"\"fat\"", "octahedral", "xyz"}),
                    option("NormalsOfALayoutWithItsOwn", {"--layout", "killzone2", "--normals", "xyz"},
                           {"--normals", "killzone2", "half floats"}),
                    option("PositionOfALayoutWithItsOwn", {"--layout", "plain", "--position", "matrix"},
                           {"--position", "plain", "32-bit floats"}),
                    option("LayoutAndVolumes", {"--layout", "visibility", "--lighting", "volumes"},
                           {"visibility", "volumes", "clustered"}),
                    option("LayoutAndHardware", {"--layout", "visibility", "--raster", "hardware"},
                           {"visibility", "raster compute", "forward"}),
                    option("TargetsOfNone", {"--layout", "visibility", "--debug", "targets"},
                           {"visibility", "no targets"}),
                    option("TargetsAndAovs", {"--debug", "targets,depth"}, {"targets"}),
                    option("Lighting", {"--lighting", "fat"}, {"\"fat\"", "fullscreen"}),
                    option("Shading", {"--shading", "fat"}, {"\"fat\"", "ggx", "blinn-phong"}),
                    option("Tonemap", {"--tonemap", "fat"}, {"\"fat\"", "khronos", "aces", "agx", "reinhard", "none"}),
                    option("AnisotropyNone", {"--anisotropy", "0"}, {"--anisotropy", "1 to 16", "0"}),
                    option("AnisotropyHuge", {"--anisotropy", "17"}, {"--anisotropy", "1 to 16", "17"}),
                    option("AnisotropyNoNumber", {"--anisotropy", "much"}, {"--anisotropy", "much"}),
                    option("Exposure", {"--exposure", "nan"}, {"exposure", "nan"}),
                    option("ExposureHuge", {"--exposure", "1000"}, {"exposure", "60"}),
                    option("Intensity", {"--hdri-intensity", "-1"}, {"intensity", "-1"}),
                    option("IntensityNan", {"--hdri-intensity", "nan"}, {"intensity", "nan"}),
                    option("Rotation", {"--hdri-rotate", "inf"}, {"--hdri-rotate", "degrees", "inf"}),
                    option("Background", {"--background", "#12345"}, {"#12345", "#rrggbb"}),
                    option("BackgroundNan", {"--background", "0,nan,0"}, {"0,nan,0"}),
                    option("Variant", {"--variant", "red"}, {"red"}),
                    option("NormalFrame", {"--normal-frame", "maya"}, {"maya", "opencv"}),
                    option("Axes", {"--axes", "maya"}, {"maya", "z-up"})),
    wrongUseName);

WrongUse output(const char* name, std::string out, std::vector<std::string> more, std::vector<std::string> says) {
  std::vector<std::string> arguments{"render",   "builtin:boxes", "--size", "64x36",
                                     "--device", "cpu",           "-o",     std::move(out)};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return {name, std::move(arguments), kUsage, std::move(says)};
}

INSTANTIATE_TEST_SUITE_P(
    Outputs, WrongUseTest,
    testing::Values(
        output("Aov", "a.exr", {"--aov", "depth,smell"}, {"\"smell\"", "distance", "geonormal", "uv"}),
        output("NoAov", "a.exr", {"--aov", ","}, {"color, raw, depth"}),
        output("Debug", "a.png", {"--debug", "smell"}, {"\"smell\"", "depth"}),
        output("DebugAndAov", "a.png", {"--debug", "depth", "--aov", "depth"}, {"--debug", "--aov"}),
        output("DebugExr", "a.exr", {"--debug", "depth"}, {".png"}),
        output("DebugJpg", "a.jpg", {"--debug", "depth"}, {"--debug writes PNG", "a.jpg"}),
        output("AovThatPngHasNot", "a.png", {"--aov", "position"}, {"position", ".exr"}),
        output("Ending", "a.jpg", {}, {"a.jpg", ".png, .exr or .npy"}),
        output("NoEnding", "a", {}, {"\"a\"", ".png, .exr or .npy"}), output("Nameless", "", {}, {"--out is required"}),
        output("NamelessDebug", "", {"--debug", "depth"}, {"--out is required"}),
        output("Placeholder", "a{time}.png", {}, {"{time}", "{aov}, {frame}, {camera}, {scene}"}),
        output("HalfPlaceholder", "a{aov.png", {}, {"{aov}"}), output("NoFolder", "nowhere/a.png", {}, {"nowhere"}),
        output("FileAsFolder", "noise.glb/a.png", {}, {"noise.glb"}),
        output("Folder", "folder.png", {}, {"folder.png", "it is a folder"}),
        output("Unwritable", "/proc/a.png", {}, {"/proc/a.png"}),
        output("FullDevice", "full.png", {}, {"full.png", "No space left"}),
        output("NameTooLong", std::string(300, 'a') + ".png", {}, {"304 bytes", "255"}),
        output("GraphUnwritable", "a.png", {"--dump-graph", "nowhere/g.dot"}, {"nowhere/g.dot"}),
        output("GraphIsAFolder", "a.png", {"--dump-graph", "scene.gltf"}, {"scene.gltf"}),
        WrongUse{"GraphOfLabels",
                 {"render", "builtin:boxes", "--labels", "l.json", "--dump-graph", "g.dot"},
                 kUsage,
                 {"--dump-graph", "-o or --pick"}},
        WrongUse{"GraphOfCorrespondence",
                 {"render", "builtin:boxes", "--time", "0", "--correspond", "c.npz", "--dump-graph", "g.dot"},
                 kUsage,
                 {"--dump-graph", "-o or --pick"}},
        output("LabelsEnding", "a.png", {"--labels", "l.txt"}, {"--labels", ".json", "l.txt"}),
        output("LabelsPerOutput", "a.png", {"--labels", "l.{aov}.json"}, {"{frame}", "l.{aov}.json"}),
        output("LabelsPlaceholder", "a.png", {"--labels", "{time}.json"}, {"{time}"}),
        output("LabelsNoFolder", "a.png", {"--labels", "nowhere/l.json"}, {"nowhere"}),
        output("LabelsPerFrame", "{frame}.png", {"--labels", "l.json", "--frames", "0-1"},
               {"--frames requires {frame} in --labels", "{frame}.json"}),
        output("LabelsOfFramesPiped", "{frame}.png", {"--labels", "-", "--frames", "0-1"},
               {"such as --labels out/{frame}.json;"}),
        output("CorrespondenceOfFramesPiped", "{frame}.png", {"--correspond", "-", "--frames", "0-1"},
               {"such as --correspond out/{frame}.npz;"}),
        output("FramesPiped", "-", {"--frames", "0-1"}, {"such as -o out/{frame}.png;"}),
        output("LabelsOverSideFile", "a.exr", {"--labels", "a.json", "--aov", "depth"}, {"a.json"}),
        output("LabelsIntoTheReport", "a.png", {"--labels", "-", "--json"}, {"--labels -", "--json"}),
        output("KeypointsAlone", "a.png", {"--keypoints", R"([{"name": "a"}])"}, {"--labels"}),
        output("KeypointsNone", "a.png", {"--labels", "l.json", "--keypoints", "[]"}, {"at least one"}),
        output("KeypointsBroken", "a.png", {"--labels", "l.json", "--keypoints", "[1"}, {"--keypoints", "JSON"}),
        output("KeypointsKey", "a.png", {"--labels", "l.json", "--keypoints", R"([{"nose": 1}])"},
               {"--keypoints[0]", "name"}),
        WrongUse{"KeypointsMissing",
                 {"render", "builtin:boxes", "--labels", "l.json", "--keypoints", "points.json"},
                 kBadInput,
                 {"points.json"}},
        output("CorrespondEnding", "a.png", {"--correspond", "c.npy", "--time", "0"}, {"--correspond", ".npz or .exr"}),
        output("CorrespondPiped", "a.png", {"--correspond", "-", "--time", "0"}, {"--correspond", ".npz or .exr"}),
        output("CorrespondPerOutput", "a.png", {"--correspond", "c.{aov}.npz"}, {"--correspond", "{frame}"}),
        output("CorrespondNoFolder", "a.png", {"--correspond", "nowhere/c.npz"}, {"nowhere"}),
        output("CorrespondPerFrame", "{frame}.png", {"--correspond", "c.npz", "--frames", "0-1"},
               {"--frames requires {frame} in --correspond", "{frame}.npz"}),
        output("CorrespondOverThePicture", "a.exr", {"--correspond", "a.exr", "--time", "0"}, {"a.exr"}),
        output("CorrespondWithNothing", "a.png", {"--correspond", "c.npz"},
               {"second picture", "--to-camera", "--to-eye", "--time"}),
        output("CorrespondAtRest", "a.png", {"--correspond", "c.npz", "--to", "next"}, {"--to", "--time or --frames"}),
        output("CorrespondTimeAtRest", "a.png", {"--correspond", "c.npz", "--to-time", "1", "--to-camera", "main"},
               {"--to-time", "--time or --frames"}),
        output("CorrespondToItself", "a.png", {"--correspond", "c.npz", "--time", "0", "--to", "0"},
               {"--to takes next, previous", "\"0\""}),
        output("CorrespondStep", "a.png", {"--correspond", "c.npz", "--time", "0", "--to", "nearest"}, {"\"nearest\""}),
        output("CorrespondTwoTimes", "a.png",
               {"--correspond", "c.npz", "--time", "0", "--to", "next", "--to-time", "1"}, {"--to and --to-time"}),
        output("CorrespondTwoCameras", "a.png",
               {"--correspond", "c.npz", "--to-camera", "main", "--to-eye", "1,1,1", "--to-target", "0,0,0"},
               {"--to-camera and --to-eye"}),
        output("CorrespondEyeAlone", "a.png", {"--correspond", "c.npz", "--to-eye", "1,1,1"},
               {"--to-eye and --to-target"}),
        output("CorrespondTarget", "a.png", {"--correspond", "c.npz", "--to-eye", "1,1,1", "--to-target", "0,0"},
               {"--to-target", "x,y,z"}),
        output("CorrespondCamera", "a.png", {"--correspond", "c.npz", "--to-camera", "back"}, {"\"back\""}),
        output("ToAlone", "a.png", {"--to", "next"}, {"--correspond"}),
        output("ToTimeAlone", "a.png", {"--to-time", "1"}, {"--correspond"}),
        output("ToCameraAlone", "a.png", {"--to-camera", "main"}, {"--correspond"}),
        output("ToTargetAlone", "a.png", {"--to-target", "0,0,0"}, {"--correspond"}),
        output("SeveralToStandardOutput", "-", {"--aov", "depth,id"}, {"-o -", "one PNG file", "2 outputs"}),
        output("ReportIntoThePicture", "-", {"--json"}, {"--json", "-o"})),
    wrongUseName);

WrongUse scene(const char* name, std::string scene, std::vector<std::string> says, int code = kBadInput) {
  return {name, {"render", std::move(scene), "-o", "a.png"}, code, std::move(says)};
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, WrongUseTest,
    testing::Values(
        scene("Missing", "missing.glb", {"missing.glb"}), scene("Folder", "scene.gltf", {"scene.gltf", "folder"}),
        scene("Noise", "noise.glb", {"noise.glb"}), scene("Empty", "empty.gltf", {"empty.gltf"}),
        scene("Half", "half.gltf", {"half.gltf"}), scene("Cut", "cut.glb", {"cut.glb"}),
        scene("Version", "old.gltf", {"old.gltf", "1.0"}),
        scene("RequiredExtension", "needs.gltf", {"needs.gltf", "KHR_materials_subsurface"}),
        scene("BufferMissing", "lost.gltf", {"lost.gltf", "lost.bin"}),
        scene("BuiltinUnknown", "builtin:castle", {"castle", "builtin:hall"}, kUsage),
        scene("BuiltinParameter", "builtin:hall,towers=3", {"towers", "triangles"}, kUsage),
        scene("BuiltinRange", "builtin:hall,triangles=5", {"triangles"}, kUsage),
        WrongUse{"Variant", {"render", "good.glb", "-o", "a.png", "--variant", "red"}, kUsage, {"red"}},
        WrongUse{
            "HdriMissing", {"render", "builtin:boxes", "-o", "a.png", "--hdri", "sky.hdr"}, kBadInput, {"sky.hdr"}},
        WrongUse{"HdriBroken",
                 {"render", "builtin:boxes", "-o", "a.png", "--hdri", "broken.hdr"},
                 kBadInput,
                 {"broken.hdr"}},
        WrongUse{
            "HdriIsAScene", {"render", "builtin:boxes", "-o", "a.png", "--hdri", "good.glb"}, kBadInput, {"good.glb"}},
        WrongUse{"HdriIsAFolder",
                 {"render", "builtin:boxes", "-o", "a.png", "--hdri", "scene.gltf"},
                 kBadInput,
                 {"scene.gltf"}}),
    wrongUseName);

const std::vector<std::string> kRender{"render", "builtin:boxes", "-o", "a.png", "--size", "64x36"};
std::vector<std::string> renderOn(const char* device) {
  std::vector<std::string> arguments = kRender;
  arguments.insert(arguments.end(), {"--device", device});
  return arguments;
}

INSTANTIATE_TEST_SUITE_P(
    Devices, WrongUseTest,
    testing::Values(
        WrongUse{"NoDriver", kRender, kNoDevice, {"doctor"}, {{"VK_DRIVER_FILES", "/nonexistent"}}},
        WrongUse{
            "NoLoader", kRender, kNoDevice, {"/nonexistent", "doctor"}, {{"LATELIGHT_VULKAN_LOADER", "/nonexistent"}}},
        WrongUse{"NoLoaderForDevices",
                 {"devices"},
                 kNoDevice,
                 {"/nonexistent", "doctor"},
                 {{"LATELIGHT_VULKAN_LOADER", "/nonexistent"}}},
        WrongUse{"NotALoader", kRender, kNoDevice, {"libc.so.6"}, {{"LATELIGHT_VULKAN_LOADER", "libc.so.6"}}},
        WrongUse{"UnknownDevice", renderOn("Voodoo"), kNoDevice, {"Voodoo", "auto, cpu"}},
        WrongUse{"UnknownNumber", renderOn("99"), kNoDevice, {"99"}},
        WrongUse{"NamelessDevice", renderOn(""), kNoDevice, {"auto, cpu"}}),
    wrongUseName);

// Runs the program as a user who may not write there. Root may write anywhere, so it runs the program as nobody
// (65534).
TEST(WrongUse, AFolderThatIsReadOnlyIsNamedBeforeRendering) {
  Folder folder;
  const std::filesystem::path locked = folder.path() / "locked", program = folder.path() / "latelight";
  std::filesystem::create_directory(locked);
  std::filesystem::copy_file(LATELIGHT_PROGRAM, program);
  chmod(locked.c_str(), 0555);
  chmod(folder.path().c_str(), 0755);
  Command command{.arguments = {"render", "builtin:boxes", "-o", "a.png"}, .folder = locked};
  if (geteuid() == 0)
    command.arguments.insert(command.arguments.begin(),
                             {"--reuid=65534", "--regid=65534", "--clear-groups", program.string()});
  const Outcome outcome = runProcess(geteuid() == 0 ? "/usr/bin/setpriv" : program, command);
  EXPECT_EQ(outcome.code, kUsage) << outcome.text();
  expectOneSentence(outcome);
  EXPECT_THAT(outcome.err, HasSubstr("ermission denied"));
  EXPECT_TRUE(std::filesystem::is_empty(locked));
}

// Messages contain names from files. These must not end the line or reach the terminal as control characters.
TEST(WrongUse, NamesFromFilesAreMadePrintable) {
  Folder folder;
  folder.write("a.gltf", R"({"asset": {"version": "2.0"}, "extensionsRequired": ["KHR\n\u001b[2J\u007fx"]})");
  const Outcome outcome = latelight({"render", folder.at("a.gltf"), "-o", folder.at("a.png")});
  EXPECT_EQ(outcome.code, kBadInput);
  expectOneSentence(outcome);
  EXPECT_THAT(outcome.err, HasSubstr("KHR??[2J?x"));
}

// A limit on the size of files simulates a disk that becomes full within the file.
TEST(WrongUse, ADiskThatFillsUpLeavesNoHalfFile) {
  Folder folder;
  const std::string command =
      "ulimit -f 8; exec '" LATELIGHT_PROGRAM "' render builtin:boxes -o a.exr --size 128x128 --device cpu";
  const Outcome outcome = runProcess(
      "/bin/sh", {.arguments = {"-c", command}, .environment = {{"LATELIGHT_NO_CACHE", "1"}}, .folder = folder.path()});
  EXPECT_EQ(outcome.code, kUsage) << outcome.text();
  expectOneSentence(outcome);
  EXPECT_THAT(outcome.err, HasSubstr("a.exr"));
  EXPECT_TRUE(folder.names().empty());
}

TEST(WrongUse, AFullStandardOutputIsAnError) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"list"},
        {"list", "--json"},
        {"devices"},
        {"doctor"},
        {"--help"},
        {"serve", "builtin:boxes", "--port", "0", "--device", "cpu"},
        {"render", "builtin:boxes", "-o", "-", "--size", "64x36", "--device", "cpu"}}) {
    const Outcome outcome =
        latelight({.arguments = arguments, .standardOutput = "/dev/full", .timeout = std::chrono::minutes(5)});
    SCOPED_TRACE(arguments[0]);
    EXPECT_EQ(outcome.code, kUsage) << outcome.text();
    expectOneSentence(outcome);
    EXPECT_THAT(outcome.err, HasSubstr("standard output"));
  }
}

// Failed runs must not change existing files.
TEST(WrongUse, AFailureKeepsTheFileThatWasThere) {
  Folder folder;
  folder.write("a.png", "an older picture");
  folder.write("noise.glb", "noise");
  EXPECT_EQ(latelight({"render", folder.at("noise.glb"), "-o", folder.at("a.png")}).code, kBadInput);
  EXPECT_EQ(folder.read("a.png"), "an older picture");
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"a.png", "noise.glb"}));
}

}  // namespace
}  // namespace latelight::app
