// Edits through the public API.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>

#include "error_of.h"
#include "models/models.h"
#include "placed.h"
#include "test_device.h"

namespace latelight {
namespace {

using test::placed;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Transform kAsItIs{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

Scene punctual() {
  return Scene(models::modelPath("punctual.glb").string());
}

// Faces +Z.
MeshData square() {
  MeshData mesh;
  mesh.name = "square";
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

Options small() {
  Options options;
  options.width = 48;
  options.height = 32;
  options.aovs = {"color", "depth", "normal"};
  return options;
}

bool operator==(const Aov& a, const Aov& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0);
  };
  return a.channels == b.channels && same(a.values, b.values) && same(a.ids, b.ids);
}

void expectSame(const Frame& actual, const Frame& expected) {
  EXPECT_EQ(actual.rgba, expected.rgba);
  for (const auto& [name, aov] : expected.aovs) EXPECT_TRUE(actual.aovs.at(name) == aov) << name;
}

TEST(EditApi, ListsWhatTheSceneHas) {
  const Scene scene = punctual();
  ASSERT_GT(scene.instances().size(), 2u);
  for (const Handle<Instance> handle : scene.instances()) {
    const Instance instance = scene.instance(handle);
    EXPECT_THAT(scene.instancesOf(instance.node), testing::Contains(handle));
    EXPECT_THAT(scene.meshes(), testing::Contains(instance.mesh));
    EXPECT_THAT(scene.materials(), testing::Contains(instance.material));
    EXPECT_THAT(scene.idManifest(), HasSubstr("\"" + std::to_string(instance.id) + "\""));
    EXPECT_THAT(scene.idManifest(), HasSubstr("\"" + std::to_string(scene.material(instance.material).id) + "\""));
    const Mesh mesh = scene.mesh(instance.mesh);
    EXPECT_GT(mesh.triangles, 0u);
    EXPECT_LT(mesh.boundsMin[0], mesh.boundsMax[0]);
  }
  std::vector<std::string> types;
  for (const Handle<Light> light : scene.lights()) types.push_back(scene.light(light).type);
  EXPECT_THAT(types, testing::UnorderedElementsAre("directional", "point", "spot"));
  EXPECT_THAT(errorOf([&] { scene.instancesOf("/nobody"); }), HasSubstr("\"/nobody\""));
}

TEST(EditApi, WhatIsReadCanBeWrittenBack) {
  Scene scene = punctual();
  Renderer renderer(scene, latelight::test::testDevice());
  const Camera camera = scene.defaultCamera(1.5f);
  const Frame before = renderer.render(camera, small());
  for (const auto handle : scene.instances()) scene.setTransform(handle, scene.instance(handle).transform);
  for (const auto handle : scene.materials()) scene.setMaterial(handle, scene.material(handle));
  for (const auto handle : scene.lights()) scene.setLight(handle, scene.light(handle));
  expectSame(renderer.render(camera, small()), before);
}

TEST(EditApi, EachFrameIsThatOfARendererMadeAfresh) {
  Scene scene = punctual();
  Renderer renderer(scene, latelight::test::testDevice());
  const Camera camera = scene.defaultCamera(1.5f);
  const Frame before = renderer.render(camera, small());
  const auto check = [&] {
    const Frame frame = renderer.render(camera, small());
    expectSame(frame, Renderer(scene, latelight::test::testDevice()).render(camera, small()));
    return frame;
  };
  Material red = scene.material(scene.materials()[0]);
  red.baseColor = {1, 0, 0, 1};
  red.roughness = 0.3f;
  scene.setMaterial(scene.materials()[0], red);
  EXPECT_NE(check().rgba, before.rgba);
  Light light = scene.light(scene.lights()[1]);
  light.color = {0.2f, 1, 0.2f};
  light.position[1] += 0.5f;
  scene.setLight(scene.lights()[1], light);
  check();
  scene.setMesh(scene.instance(scene.instances()[1]).mesh, square());
  check();
  scene.removeInstance(scene.instances().back());
  scene.removeLight(scene.lights().front());
  check();
}

TEST(EditApi, TicketsGiveTheSceneAsItWasSubmitted) {
  Scene scene = punctual();
  const Camera camera = scene.defaultCamera(1.5f);
  const Frame before = Renderer(scene, latelight::test::testDevice()).render(camera, small());
  auto renderer = std::make_unique<Renderer>(scene, latelight::test::testDevice());
  Ticket first = renderer->submit({camera}, small());
  Ticket dropped = renderer->submit({camera}, small());
  Material red = scene.material(scene.materials()[0]);
  red.baseColor = {1, 0, 0, 1};
  scene.setMaterial(scene.materials()[0], red);
  Ticket second = renderer->submit({camera, camera}, small());
  EXPECT_THAT(errorOf([&] { renderer->submit(std::vector<Camera>{}, small()); }), HasSubstr("camera"));
  dropped = std::move(first);  // assigning drops the previous one without taking its results
  renderer.reset();            // tickets keep alive what they need
  const std::vector<Frame> after = second.take();
  ASSERT_EQ(after.size(), 2u);
  expectSame(after[0], after[1]);
  expectSame(after[0], Renderer(scene, latelight::test::testDevice()).render(camera, small()));
  expectSame(dropped.take().front(), before);
  EXPECT_NE(after[0].rgba, before.rgba);
  EXPECT_TRUE(dropped.done());
  EXPECT_THAT(errorOf([&] { dropped.take(); }), HasSubstr("taken already"));
}

TEST(EditApi, TransformsAreInTheFilesFrame) {
  Scene scene = punctual();
  const Handle<Instance> moved = scene.instances().back();
  scene.setTransform(moved, placed(1, 2, -3, 0.5));
  EXPECT_EQ(scene.instance(moved).transform, placed(1, 2, -3, 0.5));
  Light light;
  light.type = "spot";
  light.position = {1, 2, 3};
  light.direction = {0, -2, 0};
  light.innerCone = 10;
  light.outerCone = 30;
  const Light read = scene.light(scene.addLight(light));
  EXPECT_EQ(read.position, light.position);
  EXPECT_EQ(read.direction, (std::array<float, 3>{0, -1, 0}));
  EXPECT_NEAR(read.innerCone, 10, 1e-5);
  EXPECT_NEAR(read.outerCone, 30, 1e-5);
}

TEST(EditApi, WhatIsAddedIsSeenAndFoundByItsIds) {
  Scene scene("builtin:boxes");
  Renderer renderer(scene, latelight::test::testDevice());
  Camera camera = scene.lookAt({0, 50, 10}, {0, 50, 0});
  Material paint;
  paint.name = "paint";
  paint.baseColor = {0.1f, 0.8f, 0.3f, 1};
  const Handle<Instance> sign =
      scene.addInstance(scene.addMesh(square()), scene.addMaterial(paint), placed(0, 50, 0), "sign");
  const auto pick = [&] { return renderer.pick(camera, {{24, 16}}, small()).front(); };
  const Pick seen = pick();
  EXPECT_EQ(seen.node, "/sign");
  EXPECT_EQ(seen.mesh, "square");
  EXPECT_EQ(seen.material, "paint");
  EXPECT_EQ(seen.id, scene.instance(sign).id);
  EXPECT_EQ(seen.part, scene.instance(sign).part);
  EXPECT_NEAR(seen.depth, 10, 1e-4);
  EXPECT_EQ(seen.geonormal, (std::array<float, 3>{0, 0, 1}));
  EXPECT_THAT(scene.idManifest(), HasSubstr("/sign"));
  EXPECT_THAT(scene.instancesOf("/sign"), testing::ElementsAre(sign));
  scene.removeInstance(sign);
  EXPECT_EQ(pick().id, 0u);
  EXPECT_THAT(scene.idManifest(), testing::Not(HasSubstr("/sign")));
  EXPECT_THAT(errorOf([&] { scene.instancesOf("/sign"); }), HasSubstr("no node \"/sign\""));
}

Transform transformOf(const Scene& scene, const std::string& path) {
  const std::vector<Node> nodes = scene.nodes();
  const auto found = std::ranges::find(nodes, path, &Node::path);
  return found == nodes.end() ? Transform{} : found->transform;
}

TEST(EditApi, NodesOfAddedInstancesMoveWithThem) {
  Scene scene;
  const Handle<Instance> box =
      scene.addInstance(scene.addMesh(square()), scene.addMaterial({}), placed(1, 0, 0), "box");
  scene.setTransform(box, placed(2, 3, 4));
  EXPECT_EQ(transformOf(scene, "/box"), placed(2, 3, 4));
  scene.addNode({.name = "other"});  // the scene's nodes can now be animated
  scene.setTransform(box, placed(5, 6, 7));
  EXPECT_EQ(transformOf(scene, "/box"), placed(5, 6, 7));
  scene.addNode({.name = "child", .parent = "/box"});
  EXPECT_EQ(transformOf(scene, "/box/child"), placed(5, 6, 7));
  scene.setTransform(box, placed(8, 9, 10));
  EXPECT_EQ(transformOf(scene, "/box"), placed(5, 6, 7)) << "the child stays, and so does the node that it follows";
  EXPECT_EQ(transformOf(scene, "/box/child"), placed(5, 6, 7));
  EXPECT_EQ(scene.instance(box).transform, placed(8, 9, 10));
}

// Like the output of an importer: normals of the triangles, and tangents along the texture coordinates.
TEST(EditApi, NormalsAreMadeWhereThereAreNone) {
  Scene scene("builtin:boxes");
  Renderer renderer(scene, latelight::test::testDevice());
  const Camera camera = scene.lookAt({0, 50, 10}, {0, 50, 0});
  MeshData roof;  // two triangles that share an edge and are tilted apart
  roof.positions = {{-1, -1, -1}, {0, -1, 0}, {0, 1, 0}, {1, -1, -1}};
  roof.indices = {0, 1, 2, 1, 3, 2};
  roof.uv = {{0, 1}, {0.5f, 1}, {0.5f, 0}, {1, 1}};
  const Handle<Mesh> mesh = scene.addMesh(roof);
  EXPECT_EQ(scene.mesh(mesh).vertices, 6u);
  EXPECT_EQ(scene.mesh(mesh).triangles, 2u);
  EXPECT_EQ(scene.mesh(mesh).boundsMin, (std::array<float, 3>{-1, -1, -1}));
  scene.addInstance(mesh, scene.addMaterial({}), placed(0, 50, 0, 2));
  const auto picks = renderer.pick(camera, {{22, 18}, {25, 18}}, small());
  const float s = std::sqrt(0.5f);
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(picks[i].normal[k], picks[i].geonormal[k], 1e-6);
    EXPECT_NEAR(picks[i].normal[0], i == 0 ? -s : s, 1e-6);
    EXPECT_NEAR(picks[i].normal[2], s, 1e-6);
  }
  roof.indices.clear();
  EXPECT_THAT(errorOf([&] { scene.setMesh(mesh, roof); }), HasSubstr("4 positions and no indices"));
  roof.positions.pop_back();
  roof.uv.pop_back();
  scene.setMesh(mesh, roof);
  EXPECT_EQ(scene.mesh(mesh).triangles, 1u);
}

TEST(EditApi, HandlesOfWhatWasRemovedAreRefused) {
  Scene scene = punctual();
  const Handle<Instance> gone = scene.instances()[1];
  const Instance was = scene.instance(gone);
  const Handle<Light> dark = scene.lights()[0];
  const Light light = scene.light(dark);
  scene.removeInstance(gone);
  scene.removeLight(dark);
  const std::string sentence = "the handle of an instance refers to a removed element";
  EXPECT_EQ(errorOf([&] { scene.setTransform(gone, kAsItIs); }), sentence);
  const Handle<Instance> next = scene.addInstance(was.mesh, was.material, was.transform);
  EXPECT_EQ(next.index, gone.index);
  EXPECT_NE(next, gone);
  EXPECT_EQ(errorOf([&] { scene.setTransform(gone, kAsItIs); }), sentence);
  EXPECT_EQ(errorOf([&] { scene.instance(gone); }), sentence);
  EXPECT_EQ(errorOf([&] { scene.assignMaterial(gone, was.material); }), sentence);
  EXPECT_EQ(errorOf([&] { scene.removeInstance(gone); }), sentence);
  EXPECT_EQ(scene.addLight(light).index, dark.index);
  EXPECT_EQ(errorOf([&] { scene.setLight(dark, light); }), "the handle of a light refers to a removed element");
  EXPECT_EQ(errorOf([&] { scene.removeLight(dark); }), "the handle of a light refers to a removed element");
  EXPECT_EQ(scene.instance(next).mesh, was.mesh);
}

TEST(EditApi, HandlesOfNothingAndOfOtherScenesAreRefused) {
  Scene scene = punctual(), other = punctual();
  EXPECT_EQ(errorOf([&] { scene.mesh({}); }), "the handle of a mesh is empty: take one from the scene");
  EXPECT_EQ(errorOf([&] { scene.material(other.materials()[0]); }),
            "the handle of a material belongs to another scene");
  EXPECT_EQ(errorOf([&] { scene.removeLight(other.lights()[0]); }), "the handle of a light belongs to another scene");
  const Handle<Material> material = scene.materials()[0];
  const Scene moved = std::move(scene);
  EXPECT_EQ(moved.material(material).name, other.material(other.materials()[0]).name);
}

TEST(EditApi, ValuesThatCannotBeAreRefused) {
  Scene scene = punctual();
  const auto instance = scene.instances()[0];
  Transform transform = kAsItIs;
  transform[3] = kNaN;
  EXPECT_THAT(errorOf([&] { scene.setTransform(instance, transform); }), HasSubstr("not finite"));
  transform = kAsItIs;
  transform[12] = 1;
  EXPECT_THAT(errorOf([&] { scene.setTransform(instance, transform); }), HasSubstr("last row 0 0 0 1"));
  Material material;
  material.name = "mine";
  material.roughness = 2;
  EXPECT_EQ(errorOf([&] { scene.addMaterial(material); }),
            "the roughness of the material \"mine\" must be between 0 and 1, not 2");
  Light light;
  light.name = "lamp";
  light.direction = {0, 0, 0};
  light.type = "spot";
  EXPECT_THAT(errorOf([&] { scene.addLight(light); }), HasSubstr("direction of the light \"lamp\""));
  light.direction = {0, 0, -1};
  light.outerCone = 100;
  EXPECT_THAT(errorOf([&] { scene.addLight(light); }), HasSubstr("cones of the light \"lamp\""));
  MeshData mesh = square();
  mesh.indices[5] = 9;
  EXPECT_EQ(errorOf([&] { scene.addMesh(mesh); }), "the mesh \"square\" has the index 9 but only 4 positions");
  mesh = square();
  mesh.normals = {{0, 0, 1}};
  EXPECT_EQ(errorOf([&] { scene.addMesh(mesh); }),
            "the mesh \"square\" has 4 positions but 1 normals: the numbers must match");
  mesh = square();
  mesh.positions[2][1] = float(kNaN);
  EXPECT_THAT(errorOf([&] { scene.addMesh(mesh); }), HasSubstr("positions of the mesh \"square\""));
}

TEST(Api, ObjectsThatWereMovedAreRefused) {
  Scene scene = punctual();
  Renderer renderer(scene, test::testDevice());
  Camera camera = scene.defaultCamera(1.5f);
  const Scene movedScene = std::move(scene);
  Renderer moved = std::move(renderer);
  EXPECT_EQ(moved.render(camera, small()).rgba.size(), 4u * 48 * 32);
  const std::string ofScene = "this scene has been moved to another object: use that one";
  for (const std::function<void()>& call : std::initializer_list<std::function<void()>>{
           [&] { scene.triangleCount(); }, [&] { scene.cameras(); }, [&] { scene.instances(); },
           [&] { scene.addCamera(camera); }, [&] { scene.addMaterial({}); }, [&] { scene.textures(); },
           [&] { scene.animations(); }, [&] { scene.addNode({}); }, [&] { scene.lookAt({}, {}, 40); },
           [&] { Renderer of(scene, test::testDevice()); }, [&] { Renderer of(scene, test::testDevice(), "none"); }})
    EXPECT_EQ(errorOf(call), ofScene);
  const std::string ofRenderer = "this renderer has been moved to another object: use that one";
  const Worlds worlds{.count = 1, .cameras = {camera}};
  const std::vector<std::array<double, 3>> rays(1);
  for (const std::function<void()>& call : std::initializer_list<std::function<void()>>{
           [&] { renderer.deviceName(); }, [&] { renderer.finish(); }, [&] { renderer.render(camera, small()); },
           [&] { renderer.submit(worlds); }, [&] { renderer.inputArray(16); },
           [&] {
             renderer.pick(camera, {{0, 0}});
           },
           [&] { renderer.cast(rays, rays); }, [&] { renderer.cast(rays, rays, CastTargets{}); },
           [&] { renderer.submitCast(worlds, {}); }, [&] { renderer.labels(camera); }, [&] { renderer.labels(worlds); },
           [&] { renderer.keypoints(camera, {}); }, [&] { renderer.correspond(camera, camera); },
           [&] { renderer.correspond(worlds); }, [&] { renderer.scan({}, std::vector<Transform>{kAsItIs}); }})
    EXPECT_EQ(errorOf(call), ofRenderer);
  renderer = std::move(moved);
  EXPECT_EQ(renderer.render(camera, small()).rgba.size(), 4u * 48 * 32);
}

// The limits of docs/conventions.md.
TEST(Api, FieldsOfViewAtTheLimitsAreAccepted) {
  Scene scene = punctual();
  Renderer renderer(scene, test::testDevice());
  Camera camera = scene.defaultCamera(1.5f);
  for (const float degrees : {179.999f, 1e-7f}) {
    camera.verticalFov = degrees;
    EXPECT_EQ(renderer.render(camera, small()).rgba.size(), 4u * 48 * 32) << degrees;
    EXPECT_NO_THROW(scene.lookAt({0, 0, 1}, {0, 0, 0}, degrees)) << degrees;
  }
  for (const float degrees : {179.9991f, 180.0f, 9.999e-8f, 0.0f, -1.0f, float(kNaN)}) {
    camera.verticalFov = degrees;
    EXPECT_THAT(errorOf([&] { renderer.render(camera, small()); }), HasSubstr("from 1e-07 to 179.999, not")) << degrees;
    EXPECT_THAT(errorOf([&] { scene.lookAt({0, 0, 1}, {0, 0, 0}, degrees); }), HasSubstr("1e-07 to 179.999"));
  }
}

TEST(Api, SurplusDistortionCoefficientsAreRefused) {
  Scene scene = punctual();
  Renderer renderer(scene, test::testDevice());
  Camera camera = scene.defaultCamera(1.5f);
  const auto render = [&](LensModel model, std::array<double, 8> distortion) {
    camera.lens = Lens{model, 48, 32, 40, 40, 24, 16, distortion};
    renderer.render(camera, small());
  };
  const auto resultOf = [&](LensModel model, std::array<double, 8> distortion) {
    return errorOf([&] { render(model, distortion); });
  };
  EXPECT_EQ(resultOf(LensModel::Pinhole, {0.5}),
            "a lens of the model pinhole has no distortion coefficients: number 1 must be 0, not 0.5");
  EXPECT_EQ(resultOf(LensModel::Equirectangular, {0, 1}),
            "a lens of the model equirectangular has no distortion coefficients: number 2 must be 0, not 1");
  EXPECT_EQ(resultOf(LensModel::Fisheye, {0.1, 0, 0, 0, 0.5, 0.5}),
            "a lens of the model fisheye has 4 distortion coefficients: number 5 must be 0, not 0.5");
  EXPECT_EQ(resultOf(LensModel::FTheta, {0, 0.02, 0, 0, 0, 0, 7}),
            "a lens of the model ftheta has 6 distortion coefficients: number 7 must be 0, not 7");
  EXPECT_NO_THROW(render(LensModel::Fisheye, {0.1, 0.01, 0.001, 1e-4}));
  EXPECT_NO_THROW(render(LensModel::FTheta, {0, 0.02, 1e-6, 1e-8, 1e-10, 1e-12}));
  EXPECT_NO_THROW(render(LensModel::OpenCv, {0.1, 0, 0, 0, 0, 0.1, 0, 1e-3}));
}

// One of eight objects is moved away, out of the picture.
TEST(Api, OneFarInstanceDoesNotChangeThePictureOfTheOthers) {
  Scene scene("builtin:boxes");
  Light lamp;
  lamp.type = "point";
  lamp.position = {0, 4, 2};
  lamp.intensity = 60;
  scene.addLight(lamp);
  Renderer renderer(scene, test::testDevice());
  const Camera camera = scene.defaultCamera(1);
  Options options;
  options.width = options.height = 64;
  options.shadows = "none";
  const Handle<Instance> moved = scene.instances()[3];
  Transform transform = scene.instance(moved).transform;
  const auto pictureAt = [&](double x) {
    transform[3] = x;
    scene.setTransform(moved, transform);
    return renderer.render(camera, options).rgba;
  };
  const std::vector<uint8_t> near = pictureAt(1000);
  for (const double far : {1e6, 1e8, 1e12, 1e18}) EXPECT_EQ(pictureAt(far), near) << far;
}

TEST(Api, EmptyNamesOfOutputsAreRefused) {
  Scene scene = punctual();
  Renderer renderer(scene, test::testDevice());
  for (const std::vector<std::string>& names : {std::vector<std::string>{""}, {"", "depth"}, {"depth", ""}}) {
    Options options = small();
    options.aovs = names;
    EXPECT_THAT(errorOf([&] { renderer.render(scene.defaultCamera(1.5f), options); }), HasSubstr("no AOV \"\""));
  }
}

}  // namespace
}  // namespace latelight
