// Arguments of the public API that are rejected where they are given, and limits that the API states.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <latelight/latelight.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "error_of.h"
#include "placed.h"
#include "test_device.h"

namespace latelight {
namespace {

using testing::HasSubstr;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Points with as many values in all fields.
LidarPoints points(size_t count) {
  LidarPoints p;
  p.position.resize(count), p.worldPosition.resize(count), p.time.resize(count), p.range.resize(count);
  p.intensity.resize(count), p.ring.resize(count), p.echo.resize(count), p.firing.resize(count);
  p.id.resize(count), p.part.resize(count), p.material.resize(count);
  return p;
}

TEST(Arguments, PointsWithFieldsOfDifferentSizesAreNotWritten) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / ("latelight_points_" + std::to_string(getpid()) + ".ply");
  const std::function<void(LidarPoints&)> changes[] = {
      [](LidarPoints& p) { p.time.clear(); }, [](LidarPoints& p) { p.position.resize(2); },
      [](LidarPoints& p) { p.time.push_back(0); }, [](LidarPoints& p) { p.worldPosition.clear(); },
      [](LidarPoints& p) { p.material.clear(); }};
  for (const auto& change : changes)
    for (const bool world : {false, true}) {
      LidarPoints changed = points(3);
      change(changed);
      EXPECT_THAT(errorOf([&] { writePoints(file, changed, world); }),
                  HasSubstr("all fields of points must have as many values"));
      EXPECT_FALSE(std::filesystem::exists(file));
    }
  writePoints(file, points(3), true);
  EXPECT_TRUE(std::filesystem::remove(file));
}

TEST(Arguments, PointLightsNeedNoDirection) {
  Scene scene;
  Light light;
  light.name = "lamp";
  light.direction = {0, 0, 0};
  const Handle<Light> added = scene.addLight(light);
  const Light read = scene.light(added);
  EXPECT_NE(read.direction, light.direction);
  scene.setLight(added, light);
  EXPECT_EQ(scene.light(added).direction, read.direction);
  for (const char* type : {"spot", "directional", "sphere", "rect"}) {
    light.type = type;
    light.size = 1;
    EXPECT_THAT(errorOf([&] { scene.addLight(light); }), HasSubstr("direction of the light \"lamp\"")) << type;
  }
}

TEST(Arguments, AddedCamerasHaveUsableLenses) {
  Scene scene;
  Camera camera;
  camera.lens = Lens{};
  EXPECT_THAT(errorOf([&] { scene.addCamera(camera); }), HasSubstr("image size of its calibration"));
  camera.lens = Lens{.model = LensModel::Pinhole, .width = 8, .height = 8, .fx = 0, .fy = 4, .cx = 4, .cy = 4};
  EXPECT_THAT(errorOf([&] { scene.addCamera(camera); }), HasSubstr("focal lengths"));
  camera.lens->fx = 4;
  camera.lens->model = static_cast<LensModel>(77);
  EXPECT_THAT(errorOf([&] { scene.addCamera(camera); }), HasSubstr("no lens model 77"));
  EXPECT_TRUE(scene.cameras().empty());
  camera.lens->model = LensModel::Pinhole;
  scene.addCamera(camera);
  camera.lens = Lens{.model = LensModel::CubeMap};  // the image's size is not known yet
  scene.addCamera(camera);
  EXPECT_EQ(scene.cameras().size(), 2u);
}

TEST(Arguments, MessagesOfOrthographicCamerasNameTheCause) {
  Scene scene;
  Camera camera;
  camera.orthographic = true;
  EXPECT_THAT(errorOf([&] { scene.addCamera(camera); }), HasSubstr("finite near and far planes"));
  camera.halfHeight = kInfinity;
  EXPECT_THAT(errorOf([&] { scene.addCamera(camera); }), HasSubstr("half height"));
  camera.halfHeight = 1;
  camera.farClip = 10;
  scene.addCamera(camera);
  EXPECT_EQ(scene.cameras().size(), 1u);
}

TEST(Arguments, UnknownEnumeratorsAreRejected) {
  Scene scene("builtin:boxes");
  const Handle<Material> material = scene.addMaterial({});
  const Handle<Texture> texture = scene.addTexture({"white", 1, 1, true, {255, 255, 255, 255}});
  for (const TextureUse& use : {TextureUse{.texture = texture, .wrapU = static_cast<Wrap>(9)},
                                TextureUse{.texture = texture, .wrapV = static_cast<Wrap>(-1)}})
    EXPECT_THAT(errorOf([&] { scene.setTexture(material, TextureSlot::BaseColor, use); }), HasSubstr("no wrap mode"));
  Renderer renderer(scene, test::testDevice());
  EXPECT_THAT(errorOf([&] { renderer.submit({scene.defaultCamera(1)}, {}, static_cast<Results>(9)); }),
              HasSubstr("no results 9"));
}

TEST(Arguments, ArraysOfWorldsHaveKnownElements) {
  Scene scene("builtin:boxes");
  Renderer renderer(scene, latelight::test::testDevice());
  const std::array<double, 3> down{0, 0, -1};
  for (const int element : {-1, 5, 100}) {
    const WorldArray unknown{.element = static_cast<WorldArray::Element>(element), .host = down.data()};
    Worlds worlds;
    worlds.count = 1;
    EXPECT_EQ(
        errorOf([&] { renderer.cast(worlds, {.origins = unknown, .directions = unknown, .count = 1}, {"distance"}); }),
        fmt::format("WorldRays::origins has unknown elements {}: choose one of WorldArray::Element", element));
  }
}

TEST(Arguments, DefaultCamerasCheckTheAspectAlsoIfTheSceneHasCameras) {
  Scene scene("builtin:boxes");
  const auto check = [&] {
    for (const float aspect : {0.0f, -1.0f, kInfinity, std::numeric_limits<float>::quiet_NaN()})
      EXPECT_THAT(errorOf([&] { scene.defaultCamera(aspect); }), HasSubstr("aspect must be a number above 0"));
  };
  check();
  scene.addCamera(scene.lookAt({0, 0, 3}, {0, 0, 0}));
  check();
}

TEST(Arguments, MeshesHavePositions) {
  Scene scene;
  EXPECT_EQ(errorOf([&] { scene.addMesh({.name = "nothing"}); }), "the mesh \"nothing\" has no positions");
}

TEST(Arguments, CamerasThatAreTooFarAwaySaySo) {
  const Scene scene;
  EXPECT_THAT(errorOf([&] { scene.lookAt({1e200, 0, 0}, {0, 0, 0}); }), HasSubstr("too far apart"));
}

TEST(Arguments, SecondTimesHaveTheRangeOfTheFirst) {
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, test::testDevice());
  const Camera camera = scene.defaultCamera(1);
  Options options;
  options.width = options.height = 8;
  options.time = 0;
  EXPECT_EQ(renderer.correspond(camera, camera, options, 1e6).width, 8u);
  for (const double time : {1e9, -1e9})
    EXPECT_THAT(errorOf([&] { renderer.correspond(camera, camera, options, time); }), HasSubstr("--time"));
}

TEST(Arguments, TargetsAreArraysOfRequestedOutputsWithTheirSize) {
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, test::testDevice());
  const Camera camera = scene.defaultCamera(1);
  const auto optionsOf = [](uint32_t width, const char* output) {
    Options options;
    options.width = width;
    options.height = 48;
    options.picture = false;
    options.aovs = {output};
    return options;
  };
  const auto render = [&](uint32_t width, const char* output, const std::map<std::string, DeviceArray>& targets) {
    return renderer.submit({camera}, optionsOf(width, output), Results::Arrays, targets).takeArrays();
  };
  const DeviceArray depth = render(48, "depth", {}).at("depth");
  EXPECT_EQ(errorOf([&] {
              render(48, "normal", {{"depth", depth}});
            }),
            "there is an array to render depth into, but this output is not requested");
  EXPECT_THAT(errorOf([&] {
                render(48, "depth", {{"depth", depth}, {"rgba", render(48, "id", {}).at("id")}});
              }),
              HasSubstr("render rgba into"));
  const DeviceArray narrow = render(47, "depth", {}).at("depth");  // its memory may be larger
  EXPECT_THAT(errorOf([&] { render(48, "depth", {{"depth", narrow}}); }), HasSubstr("is smaller than the output"));
  EXPECT_EQ(render(48, "depth", {{"depth", depth}}).at("depth").host(), depth.host());
}

TEST(Arguments, TargetsOfRaysAreThoseOfRequestedOutputs) {
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, test::testDevice());
  const Worlds worlds{.count = 1};
  const std::array<double, 6> numbers{};
  const auto rays = [&](uint64_t count) {
    return WorldRays{{.element = WorldArray::Element::Float64, .host = numbers.data()},
                     {.element = WorldArray::Element::Float64, .host = numbers.data()},
                     count};
  };
  const std::map<std::string, DeviceArray> one = renderer.cast(worlds, rays(1));
  EXPECT_EQ(errorOf([&] { renderer.cast(worlds, rays(1), std::vector<std::string>{"id"}, {}, one); }),
            "there is an array to store distance in, but this output is not requested");
  EXPECT_EQ(errorOf([&] { renderer.cast(worlds, rays(2), std::vector<std::string>{"distance"}, {}, one); }),
            "the array of distance is too small for the hits of 2 rays");
}

// 4 * 2^31 * 2^31 is 2^64, which 64 bits hold as 0.
TEST(Arguments, PngsHaveAllTheirPixels) {
  const uint32_t side = uint32_t{1} << 31;
  EXPECT_EQ(errorOf([&] { encodePng(side, side, {}); }),
            "an image of 2147483648x2147483648 pixels has 4 bytes per pixel, but 0 bytes are given");
  EXPECT_THAT(errorOf([] { encodePng(1, 1, std::vector<uint8_t>(5)); }), HasSubstr("5 bytes are given"));
  EXPECT_FALSE(encodePng(1, 1, std::vector<uint8_t>(4)).empty());
}

TEST(Arguments, CopiesToTheHostHaveTheArraysSize) {
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, test::testDevice());
  Options options;
  options.width = 16, options.height = 12;
  Ticket ticket = renderer.submit({scene.defaultCamera(1)}, options, Results::Arrays);
  const DeviceArray array = ticket.takeArrays().at("rgba");
  for (const size_t bytes : {size_t{3}, size_t{4} * 16 * 12 - 1, size_t{4} * 16 * 12 + 1}) {
    std::vector<std::byte> copy(bytes);
    EXPECT_THAT(errorOf([&] { array.copyToHost(copy); }), HasSubstr("the array has 768 bytes")) << bytes;
  }
  std::vector<std::byte> copy(size_t{4} * 16 * 12);
  array.copyToHost(copy);
  EXPECT_EQ(copy[3], std::byte{255});  // the first pixel's alpha
}

// The loader rejects OBJ and PLY files without faces.
TEST(Arguments, ExportedFilesCanBeLoaded) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("latelight_export_" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  const Scene none;
  Scene hidden;
  const Handle<Mesh> mesh = hidden.addMesh({.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .indices = {0, 1, 2}});
  const Handle<Instance> instance = hidden.addInstance(mesh, hidden.addMaterial({}), test::placed(0, 0, 0));
  hidden.removeInstance(instance);
  for (const Scene* scene : {&none, &std::as_const(hidden)}) {
    for (const char* name : {"empty.obj", "empty.ply"}) {
      EXPECT_EQ(errorOf([&] { scene->exportTo(folder / name); }),
                fmt::format("the scene has no visible triangles, and a .{} file requires at least one: export .glb",
                            std::string(name).substr(6)));
      EXPECT_FALSE(std::filesystem::exists(folder / name));
    }
    scene->exportTo(folder / "empty.glb");
    EXPECT_EQ(Scene(folder / "empty.glb").triangleCount(), 0u);
  }
  hidden.addInstance(mesh, hidden.addMaterial({}), test::placed(0, 0, 0));
  for (const char* name : {"one.obj", "one.ply", "one.glb"}) {
    hidden.exportTo(folder / name);
    EXPECT_EQ(Scene(folder / name).triangleCount(), 1u) << name;
  }
  std::filesystem::remove_all(folder);
}

// Returns the largest resident memory of this process so far, in bytes.
uint64_t peakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<uint64_t>(usage.ru_maxrss) << 10;
}

class MemoryLimit : public testing::Test {
 protected:
  ~MemoryLimit() override { setMemoryLimit(0); }
};

TEST_F(MemoryLimit, AppliesToBuiltInScenes) {
  for (const char* name : {"builtin:boxes", "builtin:spheres", "builtin:hall", "builtin:triangles,count=1"}) {
    setMemoryLimit(100);
    const std::string sentence = errorOf([&] { const Scene scene(name); }, ExitCode::OutOfMemory);
    EXPECT_THAT(sentence, HasSubstr(std::string("no memory for the scene ") + name));
    EXPECT_THAT(sentence, HasSubstr("of the 100 bytes"));
    setMemoryLimit(0);
    EXPECT_GT(Scene(name).triangleCount(), 0u);
  }
}

// A million cameras of the renderer require hundreds of megabytes.
TEST_F(MemoryLimit, AppliesToCamerasBeforeTheyAreConverted) {
  const Scene scene("builtin:boxes");
  Renderer renderer(scene, test::testDevice());
  Options options;
  options.width = options.height = 1;
  const std::vector<Camera> cameras(100'000, scene.defaultCamera(1));
  renderer.render(cameras.front(), options);
  for (const char* raster : {"compute", "hardware"}) {
    options.raster = raster;
    const Worlds worlds{.count = 1'000'000, .cameras = {cameras.front()}};
    Worlds all = worlds;
    all.count = 300'000'000;
    const uint64_t before = peakMemory();
    setMemoryLimit(1 << 20);
    EXPECT_THAT(errorOf([&] { renderer.submit(worlds, options); }, ExitCode::OutOfMemory),
                HasSubstr("no memory for the 1000000 views of 1000000 worlds"));
    EXPECT_THAT(errorOf([&] { renderer.submit(all, options); }), HasSubstr("fewer than 2^32 numbers"));
    EXPECT_THAT(errorOf([&] { renderer.submit(cameras, options); }, ExitCode::OutOfMemory),
                HasSubstr("no memory for the cameras of the call"));
    setMemoryLimit(0);
    EXPECT_LT(peakMemory() - before, uint64_t{32} << 20) << raster;
  }
  EXPECT_EQ(renderer.render(Worlds{.count = 3, .cameras = {cameras.front()}}, options).size(), 3u);
}

}  // namespace
}  // namespace latelight
