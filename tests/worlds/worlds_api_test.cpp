// Worlds through the public API: instances, cameras that ride on them, intrinsics, and errors.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <functional>
#include <limits>

#include "error_of.h"
#include "placed.h"
#include "test_device.h"
#include "worlds/same_frames.h"
#include "worlds/tiny_views.h"

namespace latelight {
namespace {

using test::placed;
using test::testDevice;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A red and a green square that face +Z, in a scene with glTF's axes.
struct Squares {
  Scene scene;
  Handle<Instance> red, green;

  Squares() {
    MeshData mesh{.name = "square", .positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}};
    mesh.indices = {0, 1, 2, 0, 2, 3};
    const Handle<Mesh> square = scene.addMesh(mesh);
    red = scene.addInstance(square, material("red", {1, 0, 0}), placed(-1, 0, 0));
    green = scene.addInstance(square, material("green", {0, 1, 0}), placed(1, 0, 0));
  }
  Handle<Material> material(const char* name, std::array<float, 3> color) {
    return scene.addMaterial({.name = name, .baseColor = {color[0], color[1], color[2], 1}, .unlit = true});
  }
};

Options small() {
  return test::tinyOptions({"depth", "id"});
}

TEST(WorldsApi, MoveAndRemoveInstances) {
  Squares made, edited;
  Renderer renderer(made.scene, testDevice()), alone(edited.scene, testDevice());
  Worlds worlds{.count = 2, .instances = {made.green, made.red}};
  worlds.transforms = {placed(1, 0, 0), placed(-2, 1, 0), placed(0.5, -1, 1, 0.5), placed(-1, 0, 0)};
  worlds.exists = {1, 1, 1, 0};
  worlds.cameras = {test::frontCamera()};
  const std::vector<Frame> frames = renderer.render(worlds, small());
  ASSERT_EQ(frames.size(), 2u);
  edited.scene.setTransform(edited.red, placed(-2, 1, 0));
  test::expectSameFrames(frames[0], alone.render(test::frontCamera(), small()));
  edited.scene.setTransform(edited.green, placed(0.5, -1, 1, 0.5));
  edited.scene.removeInstance(edited.red);
  test::expectSameFrames(frames[1], alone.render(test::frontCamera(), small()));
}

TEST(WorldsApi, CamerasHaveTheirOwnPosesAndIntrinsics) {
  Squares made;
  Renderer renderer(made.scene, testDevice());
  Worlds worlds{.count = 2};
  worlds.cameras = {test::frontCamera(), test::frontCamera()};
  const Transform near{1, 0, 0, 0.5, 0, -1, 0, 0, 0, 0, -1, 3, 0, 0, 0, 1};
  worlds.cameraToWorld = {test::frontCamera().cameraToWorld, near, near, test::frontCamera().cameraToWorld};
  worlds.intrinsics = {{20, 20, 12, 8}, {20, 20, 12, 8}, {30, 25, 10, 7}, {16, 16, 12, 8}};
  const std::vector<Frame> frames = renderer.render(worlds, small());
  ASSERT_EQ(frames.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    Camera camera = test::frontCamera();
    camera.cameraToWorld = worlds.cameraToWorld[i];
    const auto [fx, fy, cx, cy] = worlds.intrinsics[i];
    camera.lens = Lens{.width = 24, .height = 16, .fx = fx, .fy = fy, .cx = cx, .cy = cy};
    test::expectSameFrames(frames[i], renderer.render(camera, small()));
  }
}

// The pose is relative to the instance's frame without its scale.
TEST(WorldsApi, CamerasRideOnInstances) {
  Squares made;
  Renderer renderer(made.scene, testDevice());
  Worlds worlds{.count = 2, .instances = {made.red}};
  worlds.transforms = {placed(-1, 0, 2, 0.5), {0, 0, 2, 3, 0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 0, 1}};
  worlds.cameras = {test::frontCamera()};
  worlds.cameraInstances = {made.red};
  const std::vector<Frame> frames = renderer.render(worlds, small());
  Camera camera = test::frontCamera();
  camera.cameraToWorld[3] = -1;
  camera.cameraToWorld[11] = 6;
  made.scene.setTransform(made.red, worlds.transforms[0]);
  test::expectSameFrames(frames[0], renderer.render(camera, small()));
  // A quarter turn about Y: the instance's Z is the world's X, and its X is the world's -Z.
  camera.cameraToWorld = {0, 0, -1, 7, 0, -1, 0, 0, -1, 0, 0, 0, 0, 0, 0, 1};
  made.scene.setTransform(made.red, worlds.transforms[1]);
  test::expectSameFrames(frames[1], renderer.render(camera, small()));
}

TEST(WorldsApi, ChooseMaterialsAndFactors) {
  Squares made;
  Renderer renderer(made.scene, testDevice());
  const Handle<Material> blue = made.material("blue", {0, 0, 1});
  const Handle<Material> red = made.scene.instance(made.red).material;
  Worlds worlds{.count = 2, .instances = {made.red}};
  worlds.cameras = {test::frontCamera()};
  worlds.materials = {blue, red};
  const std::vector<Frame> chosen = renderer.render(worlds, small());
  test::expectSameFrames(chosen[1], renderer.render(test::frontCamera(), small()));
  made.scene.assignMaterial(made.red, blue);
  test::expectSameFrames(chosen[0], renderer.render(test::frontCamera(), small()));
  // The base color is the color of an unlit material.
  worlds.materials.clear();
  worlds.factors = {{.baseColor = {1, 1, 0, 1}}, {.baseColor = {0, 1, 1, 1}}};
  const std::vector<Frame> colored = renderer.render(worlds, small());
  for (size_t world = 0; world < 2; ++world) {
    Material material = made.scene.material(blue);
    material.baseColor = worlds.factors[world].baseColor;
    made.scene.setMaterial(blue, material);
    test::expectSameFrames(colored[world], renderer.render(test::frontCamera(), small()));
  }
  EXPECT_NE(colored[0].rgba, colored[1].rgba);
}

TEST(WorldsApi, ValuesThatAreNotFiniteAffectOnlyTheirWorld) {
  Squares made;
  Renderer renderer(made.scene, testDevice());
  Worlds worlds{.count = 4, .instances = {made.red}};
  worlds.transforms.assign(4, placed(-1, 0, 0));
  worlds.transforms[1][3] = kNaN;
  worlds.cameras = {test::frontCamera()};
  worlds.cameraToWorld.assign(4, test::frontCamera().cameraToWorld);
  worlds.cameraToWorld[2][0] = std::numeric_limits<double>::infinity();
  Ticket ticket = renderer.submit(worlds, small());
  EXPECT_EQ(ticket.invalidWorlds(), (std::vector<uint32_t>{1, 2}));
  const std::vector<Frame> frames = ticket.take();
  const Frame expected = renderer.render(test::frontCamera(), small());
  for (const size_t world : {0, 3}) test::expectSameFrames(frames[world], expected);
  for (const size_t world : {1, 2})
    EXPECT_THAT(frames[world].aovs.at("id").ids, testing::Each(0u)) << "world " << world;
}

// Expects the image of each view without a focus distance to be that with the focus at the given distance in meters.
void expectFocus(Renderer& renderer, const Worlds& worlds, const std::vector<double>& distances) {
  Options options = small();
  options.aovs = {"color"};
  options.aperture = "0.2";
  options.cameraSamples = 8;
  const std::vector<Frame> frames = renderer.render(worlds, options);
  ASSERT_EQ(frames.size(), distances.size());
  for (size_t view = 0; view < frames.size(); ++view) {
    SCOPED_TRACE(view);
    options.focusDistance = distances[view];
    test::expectSameFrames(frames[view], renderer.render(worlds, options)[view]);
  }
}

// Cameras with an aperture focus on the center of the bounds of their own world, at rest.
TEST(WorldsApi, FocusOnTheirOwnCenters) {
  Squares made;
  Renderer renderer(made.scene, testDevice());
  Worlds worlds{.count = 3, .instances = {made.red, made.green}};
  worlds.transforms = {placed(-1, 0, -6), placed(1, 0, -6), placed(0, 0, 1),
                       placed(1, 0, -6),  placed(0, 0, 2),  placed(0, 0, -4)};
  worlds.exists = {1, 1, 1, 0, 1, 1};
  Camera farther = test::frontCamera();
  farther.cameraToWorld[11] = 9;
  worlds.cameras = {test::frontCamera(), farther};
  expectFocus(renderer, worlds, {10, 15, 3, 8, 5, 10});
}

TEST(WorldsApi, FocusOnTheCentersOfTheirVertices) {
  MeshData square{.name = "square", .positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}};
  square.indices = {0, 1, 2, 0, 2, 3};
  square.normals.assign(4, {0, 0, 1});  // otherwise the mesh would have a vertex per corner of its triangles
  Scene scene;
  const Handle<Mesh> mesh = scene.addMesh(square);
  scene.addInstance(mesh, scene.addMaterial({.unlit = true}), placed(0, 0, 0));
  Renderer renderer(scene, testDevice());
  const std::vector<float> vertices{-1, -1, -4, 1, -1, -4, 1, 1, -4, -1, 1, -4,  //
                                    -1, -1, 2,  1, -1, 2,  1, 1, 2,  -1, 1, 2};
  Worlds worlds{.count = 2, .meshes = {mesh}, .cameras = {test::frontCamera()}};
  worlds.arrays.vertices = {.rows = 3, .host = vertices.data()};
  expectFocus(renderer, worlds, {8, 2});
}

// The squares in front of a wall, with an area light, a point light with a radius, and a square that emits light.
struct LitSquares : Squares {
  Handle<Instance> lamp;
  std::vector<Handle<Light>> lights;

  LitSquares() {
    const Handle<Mesh> square = scene.instance(red).mesh;
    const Handle<Material> white = scene.addMaterial({.name = "white"}),
                           glow = scene.addMaterial({.name = "glow", .emissive = {3, 2, 1}});
    scene.addInstance(square, white, placed(0, 0, -0.5, 3));
    lamp = scene.addInstance(square, glow, placed(0, 1.2, 0.5, 0.2));
    Light disk{.name = "disk", .type = "disk", .position = {0, 0, 2}, .intensity = 5, .size = 0.4};
    Light bulb{.name = "bulb", .type = "point", .position = {1, 1, 1}, .intensity = 2, .size = 0.1};
    lights = {scene.addLight(disk), scene.addLight(bulb)};
  }
};

// Worlds move the lights and what blocks them, and one removes the emissive square.
TEST(WorldsApi, AreLitByAreaLightsAndEmissiveSurfacesOfTheirOwn) {
  const LitSquares made;
  Worlds worlds{.count = 3, .instances = {made.green, made.lamp}};
  worlds.cameras = {test::frontCamera()};
  worlds.transforms = {placed(1, 0, 0),      placed(0, 1.2, 0.5, 0.2), placed(0, 0, 0.4, 0.5),
                       placed(1, 1, 1, 0.1), placed(-1, 0.5, 0.2),     placed(0, -1, 0.5, 0.3)};
  worlds.exists = {1, 1, 1, 1, 1, 0};
  worlds.lights = made.lights;
  for (uint32_t world = 0; world < 3; ++world)
    for (const Handle<Light>& light : made.lights) {
      worlds.lightValues.push_back(made.scene.light(light));
      worlds.lightValues.back().position[0] += 0.3 * world;
    }
  Options options = small();
  options.shadows = "rays";
  options.samples = 2;
  for (const char* indirect : {"none", "one-bounce"}) {
    options.indirect = indirect;
    Renderer renderer(made.scene, testDevice());
    const std::vector<Frame> frames = renderer.render(worlds, options);
    EXPECT_NE(frames[0].rgba, frames[1].rgba);
    for (uint32_t world = 0; world < 3; ++world) {
      SCOPED_TRACE(testing::Message() << indirect << ", world " << world);
      LitSquares edited;
      edited.scene.setTransform(edited.green, worlds.transforms[2 * world]);
      edited.scene.setTransform(edited.lamp, worlds.transforms[2 * world + 1]);
      for (size_t i = 0; i < 2; ++i) edited.scene.setLight(edited.lights[i], worlds.lightValues[2 * world + i]);
      if (!worlds.exists[2 * world + 1]) edited.scene.removeInstance(edited.lamp);
      Renderer alone(edited.scene, testDevice());
      test::expectSameFrames(frames[world], alone.render(test::frontCamera(), options));
    }
    EXPECT_THAT(renderer.validationMessages(), testing::IsEmpty());
  }
}

TEST(WorldsApi, RejectRaysThatTheyDoNotSupport) {
  Squares made;
  Renderer renderer(made.scene, testDevice());
  const auto refused = [&](const std::function<void(Worlds&, Options&)>& change) {
    Worlds worlds{.count = 2, .instances = {made.red}};
    worlds.cameras = {test::frontCamera()};
    Options options = small();
    change(worlds, options);
    return errorOf([&] { renderer.render(worlds, options); });
  };
  EXPECT_THAT(refused([](Worlds&, Options& o) { o.ground = "shadow"; }), HasSubstr("requires --ground-height"));
}

TEST(WorldsApi, RejectWrongLists) {
  Squares made;
  Renderer renderer(made.scene, testDevice());
  const auto refused = [&](const std::function<void(Worlds&)>& change) {
    Worlds worlds{.count = 2, .instances = {made.red}};
    worlds.cameras = {test::frontCamera()};
    change(worlds);
    return errorOf([&] { renderer.render(worlds, small()); });
  };
  EXPECT_THAT(refused([](Worlds& w) { w.count = 0; }), HasSubstr("Worlds::count must be at least 1"));
  EXPECT_THAT(refused([](Worlds& w) { w.cameras.clear(); }), HasSubstr("at least one camera"));
  EXPECT_THAT(refused([](Worlds& w) { w.transforms.resize(3); }),
              HasSubstr("Worlds::transforms must have 2 values, one per world and instance, and has 3"));
  EXPECT_THAT(refused([](Worlds& w) { w.factors.assign(2, {.roughness = 2}); }),
              HasSubstr("roughness at most 1, and one of world 0 is not"));
  EXPECT_THAT(refused([](Worlds& w) { w.lightValues.resize(2); }), HasSubstr("Worlds::lightValues must have 0 values"));
  EXPECT_THAT(refused([](Worlds& w) { w.environmentIntensity.assign(2, -1); }),
              HasSubstr("at least 0, and that of world 0"));
  EXPECT_THAT(refused([](Worlds& w) { w.exists = {1}; }), HasSubstr("Worlds::exists must have 2 values"));
  EXPECT_THAT(refused([](Worlds& w) { w.cameraToWorld.resize(1); }), HasSubstr("one per world and camera"));
  EXPECT_THAT(refused([](Worlds& w) { w.previousTransforms.resize(2); }), HasSubstr("require transforms"));
  EXPECT_THAT(refused([&](Worlds& w) { w.instances.push_back(made.red); }),
              HasSubstr("instances of worlds must be listed once each"));
  EXPECT_THAT(refused([](Worlds& w) { w.cameraInstances.resize(2); }), HasSubstr("one value per camera, 1, not 2"));
  EXPECT_THAT(refused([](Worlds& w) { w.cameraToWorld.assign(2, placed(0, 0, 0, 2)); }),
              HasSubstr("must be a rotation and a translation"));
  made.scene.removeInstance(made.red);
  EXPECT_THAT(refused([](Worlds&) {}), HasSubstr("removed"));
}

}  // namespace
}  // namespace latelight
