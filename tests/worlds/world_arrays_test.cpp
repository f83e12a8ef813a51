// Worlds whose arrays shaders convert: many random worlds have the bytes of the scene edited to their states, with
// arrays of floats and doubles, of three and four rows, through the public API.
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <tuple>

#include "long_tests.h"
#include "models/models.h"
#include "test_device.h"
#include "worlds/rejection.h"
#include "worlds/same_frames.h"

namespace latelight {
namespace {

using test::rejectionOf;
using test::testDevice;

Transform product(const Transform& a, const Transform& b) {
  Transform c{};
  for (size_t i = 0; i < 16; ++i)
    for (size_t k = 0; k < 4; ++k) c[i] += a[i / 4 * 4 + k] * b[k * 4 + i % 4];
  return c;
}

// Moved, turned about an axis, and scaled, mirrored in one of four cases. All numbers are floats, so that arrays of
// floats and of doubles describe the same worlds.
Transform randomMotion(std::mt19937& random, bool rigid) {
  std::uniform_real_distribution<double> offset(-0.4, 0.4), size(0.7, 1.3);
  const double angle = offset(random), c = std::cos(angle), s = std::sin(angle);
  Transform turn{c, -s, 0, offset(random), s, c, 0, offset(random), 0, 0, 1, offset(random), 0, 0, 0, 1};
  if (random() % 2) turn = {c, 0, s, offset(random), 0, 1, 0, offset(random), -s, 0, c, offset(random), 0, 0, 0, 1};
  const double x = random() % 4 ? size(random) : -size(random);
  if (rigid) return turn;
  return product(turn, {x, 0, 0, 0, 0, size(random), 0, 0, 0, 0, size(random), 0, 0, 0, 0, 1});
}

Transform asFloats(Transform transform) {
  for (double& number : transform) number = static_cast<float>(number);
  return transform;
}

// The numbers of matrices as an array with these elements and rows.
struct Numbers {
  std::vector<double> doubles;
  std::vector<float> floats;
  WorldArray array;

  Numbers(const std::vector<Transform>& matrices, bool asDoubles, uint32_t rows) {
    for (const Transform& m : matrices) doubles.insert(doubles.end(), m.begin(), m.begin() + 4 * rows);
    floats.assign(doubles.begin(), doubles.end());
    array.element = asDoubles ? WorldArray::Element::Float64 : WorldArray::Element::Float32;
    array.rows = rows;
    array.host = asDoubles ? static_cast<const void*>(doubles.data()) : floats.data();
  }
};

Options options(const char* raster) {
  Options o;
  o.width = 20;
  o.height = 15;
  o.raster = raster;
  o.shadows = "none";
  // Without coordinates of objects at rest, which worlds do not change and edits do.
  for (const OutputInfo& output : outputInfos())
    if (!output.name.starts_with("raster") && output.name != "object-position" && output.name != "nocs")
      o.aovs.push_back(output.name);
  return o;
}

class ArraysOfWorlds : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Rasters, ArraysOfWorlds, testing::Values("compute", "hardware"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(ArraysOfWorlds, GiveTheImagesOfTheEditedScene) {
  const bool compute = std::string(GetParam()) == "compute";
  const uint32_t kWorlds = compute ? latelight::test::rounds(200u, 30u) : 12;
  for (const char* name : {"blended.glb", "textured.glb"}) {
    const std::string file = models::modelPath(name).string();
    Scene scene(file), edited(file);
    const std::vector<Handle<Instance>> all = scene.instances(), same = edited.instances();
    Worlds worlds{.count = kWorlds, .instances = {all[0], all.back()}};
    if (all.size() == 1) worlds.instances.pop_back();
    const size_t listed = worlds.instances.size();
    worlds.cameras = {scene.defaultCamera(4.0f / 3), scene.defaultCamera(4.0f / 3)};
    std::mt19937 random(5);
    std::vector<Transform> transforms, previous, poses;
    for (size_t i = 0; i < kWorlds * listed; ++i) {
      const Transform here = scene.instance(worlds.instances[i % listed]).transform;
      transforms.push_back(asFloats(product(here, randomMotion(random, false))));
      previous.push_back(asFloats(product(here, randomMotion(random, false))));
    }
    for (size_t i = 0; i < 2 * kWorlds; ++i)
      poses.push_back(asFloats(product(worlds.cameras[i % 2].cameraToWorld, randomMotion(random, true))));
    const bool doubles = std::string(name) == "textured.glb";
    const Numbers moved(transforms, doubles, doubles ? 4 : 3), seen(poses, !doubles, 3), before(previous, doubles, 3);
    worlds.arrays = {.transforms = moved.array, .previousTransforms = before.array, .cameraToWorld = seen.array};
    Renderer renderer(scene, testDevice()), alone(edited, testDevice());
    const Options o = options(GetParam());
    Options withoutMotion = o;
    std::erase(withoutMotion.aovs, "motion");
    std::erase(withoutMotion.aovs, "flow");
    Worlds still = worlds;
    still.arrays.previousTransforms = {};
    const std::vector<Frame> frames = renderer.render(still, withoutMotion);
    ASSERT_EQ(frames.size(), 2 * kWorlds);
    for (uint32_t world = 0; world < kWorlds && !HasFailure(); world += compute ? 1 : 3) {
      for (size_t i = 0; i < listed; ++i)
        edited.setTransform(i == 0 ? same[0] : same.back(), transforms[world * listed + i]);
      for (size_t i = 0; i < 2; ++i) {
        SCOPED_TRACE(testing::Message() << name << ", world " << world << ", camera " << i);
        Camera camera = worlds.cameras[i];
        camera.cameraToWorld = poses[2 * world + i];
        test::expectSameFrames(frames[2 * world + i], alone.render(camera, withoutMotion));
      }
    }
    // The same values as lists, which have motion, too.
    Worlds lists = worlds;
    lists.arrays = {};
    lists.transforms = transforms;
    lists.previousTransforms = previous;
    lists.cameraToWorld = poses;
    const std::vector<Frame> given = renderer.render(worlds, o), listedFrames = renderer.render(lists, o);
    for (size_t i = 0; i < given.size() && !HasFailure(); i += 7) test::expectSameFrames(given[i], listedFrames[i]);
  }
}

// Factors of materials and the environment of each world as arrays have the images of the same values as lists. Alpha
// makes blended materials opaque in some worlds.
TEST_P(ArraysOfWorlds, HaveMaterialsAndEnvironments) {
  constexpr uint32_t kSome = 16;
  for (const char* name : {"blended.glb", "textured.glb"}) {
    SCOPED_TRACE(name);
    Scene scene(models::modelPath(name).string());
    Renderer renderer(scene, testDevice(), "studio");
    Worlds lists{.count = kSome, .instances = scene.instances(), .cameras = {scene.defaultCamera(4.0f / 3)}};
    std::mt19937 random(9);
    std::uniform_real_distribution<float> share(0.1f, 1);
    const size_t listed = lists.instances.size();
    std::vector<float> color, emissive, metallic, intensity;
    std::vector<double> roughness, rotation;
    for (size_t i = 0; i < kSome * listed; ++i) {
      MaterialFactors& f = lists.factors.emplace_back();
      f = {.baseColor = {share(random), share(random), share(random), random() % 3 ? 1 : share(random)},
           .metallic = share(random),
           .roughness = share(random),
           .emissive = {0, 0.2f * share(random), 0}};
      color.insert(color.end(), f.baseColor.begin(), f.baseColor.end());
      emissive.insert(emissive.end(), f.emissive.begin(), f.emissive.end());
      metallic.push_back(f.metallic);
      roughness.push_back(f.roughness);
      if (random() % 2)
        lists.materials.push_back(scene.materials()[random() % scene.materials().size()]);
      else
        lists.materials.push_back(scene.instance(lists.instances[i % listed]).material);
    }
    for (uint32_t world = 0; world < kSome; ++world) {
      rotation.push_back(720.0 * share(random) - 300);
      intensity.push_back(share(random));
    }
    Worlds arrays = lists;
    arrays.factors.clear();
    lists.environmentRotation = rotation;
    lists.environmentIntensity = intensity;
    using enum WorldArray::Element;
    arrays.arrays = {.baseColor = {.element = Float32, .host = color.data()},
                     .metallic = {.element = Float32, .host = metallic.data()},
                     .roughness = {.element = Float64, .host = roughness.data()},
                     .emissive = {.element = Float32, .host = emissive.data()},
                     .environmentRotation = {.element = Float64, .host = rotation.data()},
                     .environmentIntensity = {.element = Float32, .host = intensity.data()}};
    Options o = options(GetParam());
    o.background = "hdri";
    const std::vector<Frame> expected = renderer.render(lists, o);
    for (int call = 0; call < 2; ++call) {
      const std::vector<Frame> frames = renderer.render(arrays, o);
      ASSERT_EQ(frames.size(), kSome);
      for (uint32_t world = 0; world < kSome && !HasFailure(); ++world) {
        SCOPED_TRACE(world);
        test::expectSameFrames(frames[world], expected[world]);
      }
    }
    // The material's own factors replace those that are not given.
    for (size_t i = 0; i < lists.factors.size(); ++i) {
      const Material own = scene.material(lists.materials[i]);
      lists.factors[i] = {own.baseColor, own.metallic, lists.factors[i].roughness, own.emissive};
    }
    arrays.arrays.baseColor = arrays.arrays.metallic = arrays.arrays.emissive = {};
    const std::vector<Frame> frames = renderer.render(arrays, o), other = renderer.render(lists, o);
    for (uint32_t world = 0; world < kSome && !HasFailure(); ++world)
      test::expectSameFrames(frames[world], other[world]);
    // Wrong values.
    roughness[3] = std::nan("");
    Ticket ticket = renderer.submit(arrays, o);
    EXPECT_EQ(ticket.invalidWorlds(), std::vector<uint32_t>{static_cast<uint32_t>(3 / listed)});
    ticket.take();
    roughness[3] = 1.5;
    EXPECT_THROW(renderer.render(arrays, o), Error);
    roughness[3] = 1;
    intensity[1] = -1;
    EXPECT_THROW(renderer.render(arrays, o), Error);
  }
}

// Lights of each world as arrays, of all types and more than one box of the light tree holds. Some of them emit nothing
// in some worlds. `turned`: area lights have directions of their own, too, which the host converts.
void compareLights(const char* raster, bool turned) {
  constexpr uint32_t kSome = 12;
  const std::string file = models::modelPath("punctual.glb").string();
  Scene scene(file), edited(file);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> share(0.05f, 1), side(-3, 3);
  for (const char* type : {"point", "spot", "rect", "directional", "sphere", "tube"})
    for (int i = 0; i < (type[0] == 'p' ? 40 : 3); ++i) {
      Light light{.type = type, .position = {side(random), 2, side(random)}, .intensity = 2, .size = 0.25};
      if (i % 2 && type[0] == 'p') light.range = 1 + 3 * share(random);
      for (Scene* each : {&scene, &edited}) each->addLight(light);
    }
  const auto isArea = [&](Handle<Light> light) {
    const std::string type = scene.light(light).type;
    return type == "rect" || type == "sphere" || type == "tube";
  };
  Worlds worlds{.count = kSome, .cameras = {scene.defaultCamera(4.0f / 3)}};
  std::vector<size_t> listed;  // indices in the scene's lights
  for (size_t i = 0; i < scene.lights().size(); ++i)
    if (turned || i % 5 != 4) listed.push_back(i);
  for (const size_t i : listed) worlds.lights.push_back(scene.lights()[i]);
  std::vector<double> position;
  std::vector<float> direction, color, intensity;
  for (size_t i = 0; i < kSome * listed.size(); ++i) {
    const Light own = scene.light(worlds.lights[i % listed.size()]);
    const bool keeps = random() % 3 == 0;  // its node, if it has one
    for (size_t axis = 0; axis < 3; ++axis) position.push_back(keeps ? own.position[axis] : double{side(random)});
    for (size_t axis = 0; axis < 3; ++axis) direction.push_back(keeps ? own.direction[axis] : side(random));
    for (size_t axis = 0; axis < 3; ++axis) color.push_back(share(random));
    intensity.push_back(random() % 4 ? 3 * share(random) : 0);
  }
  using enum WorldArray::Element;
  worlds.arrays = {.lightPosition = {.element = Float64, .host = position.data()},
                   .lightColor = {.element = Float32, .host = color.data()},
                   .lightIntensity = {.element = Float32, .host = intensity.data()}};
  const bool givesDirections = turned || std::ranges::none_of(worlds.lights, isArea);
  if (givesDirections) worlds.arrays.lightDirection = {.element = Float32, .host = direction.data()};
  Renderer renderer(scene, testDevice(), "studio"), alone(edited, testDevice(), "studio");
  Options o = options(raster);
  o.aovs = {"color", "lights-used"};
  for (int call = 0; call < 3; ++call) {
    const std::vector<Frame> frames = renderer.render(worlds, o);
    ASSERT_EQ(frames.size(), kSome);
    for (uint32_t world = 0; world < kSome && !testing::Test::HasFailure(); world += 1 + 4 * call) {
      SCOPED_TRACE(testing::Message() << "world " << world << ", call " << call);
      for (size_t i = 0; i < listed.size(); ++i) {
        const size_t row = world * listed.size() + i;
        Light light = scene.light(worlds.lights[i]);
        for (size_t axis = 0; axis < 3; ++axis) {
          light.position[axis] = position[3 * row + axis];
          if (givesDirections) light.direction[axis] = direction[3 * row + axis];
          light.color[axis] = color[3 * row + axis];
        }
        light.intensity = intensity[row];
        edited.setLight(edited.lights()[listed[i]], light);
      }
      test::expectSameFrames(frames[world], alone.render(worlds.cameras[0], o));
    }
  }
  if (turned) return;
  position[4] = std::nan("");
  EXPECT_EQ(renderer.submit(worlds, o).invalidWorlds(), std::vector<uint32_t>{0});
  position[4] = 0;
  intensity.back() = -1;
  EXPECT_THROW(renderer.render(worlds, o), Error);
}

TEST_P(ArraysOfWorlds, HaveLights) {
  compareLights(GetParam(), false);
}

TEST_P(ArraysOfWorlds, HaveTurnedAreaLights) {
  compareLights(GetParam(), true);
}

// The materials of each world as indices, alone and with factors.
TEST_P(ArraysOfWorlds, ChooseMaterials) {
  constexpr uint32_t kSome = 20;
  for (const char* name : {"blended.glb", "textured.glb"}) {
    SCOPED_TRACE(name);
    const std::string file = models::modelPath(name).string();
    Scene scene(file), edited(file);
    for (Scene* each : {&scene, &edited})
      each->addMaterial({.baseColor = {0.2f, 0.7f, 0.4f, 0.5f}, .alphaMode = AlphaMode::Blend});
    Worlds worlds{.count = kSome, .instances = scene.instances(), .palette = scene.materials()};
    worlds.cameras = {scene.defaultCamera(4.0f / 3)};
    std::mt19937 random(3);
    const size_t listed = worlds.instances.size();
    std::vector<int64_t> longs;
    for (size_t i = 0; i < kSome * listed; ++i) longs.push_back(static_cast<int64_t>(random() % worlds.palette.size()));
    const std::vector<int32_t> ints(longs.begin(), longs.end());
    using enum WorldArray::Element;
    Renderer renderer(scene, testDevice(), "studio"), alone(edited, testDevice(), "studio");
    const Options o = options(GetParam());
    for (int call = 0; call < 3; ++call) {
      worlds.arrays.materialChoice = {.element = Int64, .host = longs.data()};
      if (call == 1) worlds.arrays.materialChoice = {.element = Int32, .host = ints.data()};
      const std::vector<Frame> frames = renderer.render(worlds, o);
      for (uint32_t world = 0; world < kSome && !HasFailure(); ++world) {
        SCOPED_TRACE(world);
        for (size_t i = 0; i < listed; ++i)
          edited.assignMaterial(edited.instances()[i],
                                edited.materials()[static_cast<size_t>(longs[world * listed + i])]);
        test::expectSameFrames(frames[world], alone.render(worlds.cameras[0], o));
      }
    }
    const std::vector<float> roughness(kSome * listed, 0.75f);
    worlds.arrays.roughness = {.element = Float32, .host = roughness.data()};
    const std::vector<Frame> frames = renderer.render(worlds, o);
    Worlds lists = worlds;
    lists.arrays.materialChoice = {};
    lists.palette.clear();
    for (const int64_t choice : longs) lists.materials.push_back(worlds.palette[static_cast<size_t>(choice)]);
    const std::vector<Frame> expected = renderer.render(lists, o);
    for (uint32_t world = 0; world < kSome && !HasFailure(); ++world)
      test::expectSameFrames(frames[world], expected[world]);
    longs[1] = static_cast<int64_t>(worlds.palette.size());
    EXPECT_THROW(renderer.render(worlds, o), Error);
    longs[1] = -1;
    EXPECT_THROW(renderer.render(worlds, o), Error);
  }
}

// Writes an environment whose radiance changes with the direction, as a Radiance file of flat (not run-length coded)
// pixels. `exponent`: 128 is a radiance of about 0.5; with 147, values exceed the largest half float.
std::string writeEnvironment(const std::string& name, uint32_t height, uint8_t exponent) {
  const std::string path = testing::TempDir() + "/" + name;
  std::ofstream file(path, std::ios::binary);
  file << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " << height << " +X " << 2 * height << "\n";
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < 2 * height; ++x) {
      const bool sun = y == height / 4 && x == height / 3;
      const auto red = static_cast<char>(130 + 60 * x / height), green = static_cast<char>(180 - 50 * y / height);
      const char pixel[] = {red, green, static_cast<char>(140), static_cast<char>(sun ? exponent : 128)};
      file.write(pixel, 4);
    }
  return path;
}

// Each world has the environment of its index. The maps differ in size and in the type of their texels.
TEST_P(ArraysOfWorlds, ChooseEnvironments) {
  constexpr uint32_t kSome = 12;
  const std::vector<std::string> names{"studio", writeEnvironment("small.hdr", 16, 130),
                                       writeEnvironment("large.hdr", 260, 131),
                                       writeEnvironment("bright.hdr", 16, 147)};
  Scene scene(models::modelPath("textured.glb").string());
  Worlds worlds{.count = kSome, .environments = names, .cameras = {scene.defaultCamera(4.0f / 3)}};
  std::mt19937 random(21);
  std::vector<int64_t> index;
  for (uint32_t world = 0; world < kSome; ++world) {
    index.push_back(world < names.size() ? world : static_cast<int64_t>(random() % names.size()));
    worlds.environmentRotation.push_back(30.0 * world);
  }
  worlds.arrays.environmentIndex = {.element = WorldArray::Element::Int64, .host = index.data()};
  Options o = options(GetParam());
  o.background = "hdri";
  for (const char* own : {"none", "studio"}) {
    Renderer renderer(scene, testDevice(), own);
    std::vector<std::unique_ptr<Renderer>> alone;
    for (const std::string& name : names) alone.push_back(std::make_unique<Renderer>(scene, testDevice(), name));
    for (int call = 0; call < 3; ++call) {
      const std::vector<Frame> frames = renderer.render(worlds, o);
      for (uint32_t world = 0; world < kSome && !HasFailure(); ++world) {
        SCOPED_TRACE(testing::Message() << own << ", call " << call << ", world " << world);
        Options turned = o;
        turned.environmentRotation = worlds.environmentRotation[world];
        test::expectSameFrames(frames[world],
                               alone[static_cast<size_t>(index[world])]->render(worlds.cameras[0], turned));
      }
    }
    // Other calls have the renderer's own environment.
    o.background = "transparent";
    Renderer other(scene, testDevice(), own);
    test::expectSameFrames(renderer.render(worlds.cameras[0], o), other.render(worlds.cameras[0], o));
    o.background = "hdri";
    Worlds lists = worlds;
    lists.arrays = {};
    lists.environmentIndex.assign(index.begin(), index.end());
    const std::vector<Frame> given = renderer.render(worlds, o), listed = renderer.render(lists, o);
    for (uint32_t world = 0; world < kSome && !HasFailure(); ++world)
      test::expectSameFrames(given[world], listed[world]);
  }
  Renderer renderer(scene, testDevice());
  index[1] = static_cast<int64_t>(names.size());
  EXPECT_THROW(renderer.render(worlds, o), Error);
  index[1] = 0;
  worlds.environments.clear();
  EXPECT_THROW(renderer.render(worlds, o), Error);
  worlds.environments.assign(4, "none");
  EXPECT_THROW(renderer.render(worlds, o), Error);
}

// Rays that leave a world see its own environment, with its rotation and intensity.
void compareEnvironments(Options o) {
  constexpr uint32_t kSome = 5;
  const std::vector<std::string> names{"studio", writeEnvironment("paths.hdr", 16, 133),
                                       writeEnvironment("wide.hdr", 130, 131)};
  Scene scene("builtin:boxes");
  for (const Handle<Light>& light : scene.lights()) scene.removeLight(light);
  Worlds worlds{.count = kSome, .environments = names, .cameras = {scene.lookAt({3, 2, 4}, {0, 0, 0})}};
  const std::vector<int64_t> index{0, 1, 2, 1, 0};
  worlds.environmentRotation = {0, 50, -100, 200, 10};
  worlds.environmentIntensity = {1, 0.5f, 2, 0.7f, 0};
  worlds.arrays.environmentIndex = {.element = WorldArray::Element::Int64, .host = index.data()};
  o.aovs = {"color"};
  o.samples = 2;
  Renderer renderer(scene, testDevice());
  std::vector<std::unique_ptr<Renderer>> alone;
  for (const std::string& name : names) alone.push_back(std::make_unique<Renderer>(scene, testDevice(), name));
  std::vector<Frame> frames;
  for (int call = 0; call < 3; ++call) {  // the third one is a replay
    frames = renderer.render(worlds, o);
    for (uint32_t world = 0; world < kSome && !testing::Test::HasFailure(); ++world) {
      SCOPED_TRACE(testing::Message() << "call " << call << ", world " << world);
      Options own = o;
      own.environmentRotation = worlds.environmentRotation[world];
      own.environmentIntensity = worlds.environmentIntensity[world];
      test::expectSameFrames(frames[world], alone[static_cast<size_t>(index[world])]->render(worlds.cameras[0], own));
    }
  }
  EXPECT_NE(frames[0].rgba, frames[1].rgba);
  EXPECT_NE(frames[1].rgba, frames[2].rgba);
  // Calls with the renderer's own environment, which is none here, are not affected.
  Renderer dark(scene, testDevice());
  test::expectSameFrames(renderer.render(worlds.cameras[0], o), dark.render(worlds.cameras[0], o));
}

TEST(PlacedWorlds, SeeTheirEnvironmentsAlongPaths) {
  Options o = options("compute");
  o.indirect = "one-bounce";
  o.ground = "shadow";
  o.groundHeight = -0.5f;
  compareEnvironments(o);
}

TEST(PlacedWorlds, SeeTheirEnvironmentsAlongSharedPaths) {
  Options o = options("compute");
  o.indirect = "path";
  compareEnvironments(o);
}

TEST(PlacedWorlds, SeeTheirEnvironmentsInTheReference) {
  Options o = options("compute");
  o.lighting = "reference";
  o.background = "hdri";
  compareEnvironments(o);
}

// Between two calls with the same list, shaders write the same values from an array, and into a larger buffer.
TEST(PlacedWorlds, HaveTheValuesOfListsAfterCallsWithArrays) {
  Scene scene("builtin:boxes");
  for (const Handle<Light>& light : scene.lights()) scene.removeLight(light);
  const std::vector<float> intensity{3, 0.25f, 2, 0.7f, 0.1f, 1, 0.2f, 5};
  const std::vector<uint8_t> exists(intensity.size() * scene.instances().size(), 1);
  Worlds listed{.count = 2, .environmentIntensity = {1, 0.5f}, .cameras = {scene.lookAt({3, 2, 4}, {0, 0, 0})}};
  listed.arrays.exists = {.element = WorldArray::Element::Uint8, .host = exists.data()};
  Renderer renderer(scene, testDevice(), "studio"), alone(scene, testDevice(), "studio");
  const Options o = options("compute");
  for (const uint32_t count : {2u, 8u}) {
    Worlds worlds = listed;
    worlds.count = count;
    worlds.environmentIntensity.clear();
    worlds.arrays.environmentIntensity = {.element = WorldArray::Element::Float32, .host = intensity.data()};
    renderer.render(listed, o);
    renderer.render(worlds, o);
    const std::vector<Frame> frames = renderer.render(listed, o);
    for (uint32_t world = 0; world < listed.count; ++world) {
      SCOPED_TRACE(testing::Message() << "after " << count << " worlds, world " << world);
      Options own = o;
      own.environmentIntensity = listed.environmentIntensity[world];
      test::expectSameFrames(frames[world], alone.render(listed.cameras[0], own));
    }
  }
}

// Rays find the shadows of point, spot and directional lights of each world, some of which are dark, and of the scene.
TEST(PlacedWorlds, CastShadowsByRaysOfTheirLights) {
  constexpr uint32_t kSome = 6;
  Scene scene("builtin:boxes"), edited("builtin:boxes");
  for (Scene* each : {&scene, &edited}) {
    for (const Handle<Light>& light : each->lights()) each->removeLight(light);
    each->addLight({.type = "point", .position = {1, 2, 1}, .intensity = 8, .size = 0.2});
    each->addLight({.type = "spot", .position = {-1, 3, 1}, .direction = {0.3f, -1, -0.3f}, .intensity = 20});
    each->addLight({.type = "point", .position = {0, 2, 2}, .intensity = 4, .castShadow = false});
    each->addLight({.type = "directional", .direction = {-0.6f, -1, 0.1f}, .intensity = 1});
    each->addLight({.type = "point", .position = {2, 1, -1}, .intensity = 8, .range = 4});
    each->addLight({.type = "directional", .direction = {0.4f, -1, 0.5f}, .intensity = 1, .size = 0.05});
  }
  Worlds worlds{.count = kSome, .cameras = {scene.lookAt({3, 2, 4}, {0, 0, 0}), scene.lookAt({-2, 3, 2}, {0, 0, 0})}};
  worlds.lights = scene.lights();
  worlds.lights.pop_back();
  const size_t listed = worlds.lights.size();
  std::mt19937 random(17);
  std::uniform_real_distribution<float> share(0.2f, 1), side(-2, 2);
  std::vector<float> position, intensity;
  for (size_t i = 0; i < kSome * listed; ++i) {
    for (const float value : {side(random), 1 + 2 * share(random), side(random)}) position.push_back(value);
    intensity.push_back(random() % 4 ? 9 * share(random) : 0);
  }
  for (size_t i = 0; i < listed; ++i) intensity[i] = i == 2 ? 5 : 0;  // no light of the first world casts shadows
  using enum WorldArray::Element;
  worlds.arrays = {.lightPosition = {.element = Float32, .host = position.data()},
                   .lightIntensity = {.element = Float32, .host = intensity.data()}};
  Options o = options("compute"), unshadowed = o;
  o.width = unshadowed.width = 40;
  o.height = unshadowed.height = 30;
  o.aovs = unshadowed.aovs = {"color"};
  o.shadows = "rays";
  o.samples = 2;
  Renderer renderer(scene, testDevice(), "studio"), alone(edited, testDevice(), "studio");
  for (int call = 0; call < 3; ++call) {
    const std::vector<Frame> frames = renderer.render(worlds, o), lit = renderer.render(worlds, unshadowed);
    bool differs = false;
    for (uint32_t world = 0; world < kSome && !HasFailure(); ++world) {
      for (size_t i = 0; i < listed; ++i) {
        Light light = scene.light(worlds.lights[i]);
        for (size_t axis = 0; axis < 3; ++axis) light.position[axis] = position[3 * (world * listed + i) + axis];
        light.intensity = intensity[world * listed + i];
        edited.setLight(edited.lights()[i], light);
      }
      for (size_t i = 0; i < 2; ++i) {
        SCOPED_TRACE(testing::Message() << "call " << call << ", world " << world << ", camera " << i);
        test::expectSameFrames(frames[2 * world + i], alone.render(worlds.cameras[i], o));
        differs |= frames[2 * world + i].rgba != lit[2 * world + i].rgba;
      }
    }
    EXPECT_TRUE(differs) << "something is in the shadow";
  }
  // Lists, which the host converts, take turns with arrays. From the third call on, both are replays of their own.
  Worlds lists = worlds;
  lists.arrays = {};
  for (size_t i = 0; i < kSome * listed; ++i) {
    Light light = scene.light(worlds.lights[i % listed]);
    for (size_t axis = 0; axis < 3; ++axis) light.position[axis] = position[3 * i + axis];
    light.intensity = intensity[i];
    lists.lightValues.push_back(light);
  }
  for (int call = 0; call < 3; ++call) {
    const std::vector<Frame> given = renderer.render(worlds, o), listedFrames = renderer.render(lists, o);
    for (size_t i = 0; i < given.size() && !HasFailure(); ++i) test::expectSameFrames(given[i], listedFrames[i]);
  }
  worlds.arrays = {};  // the scene's lights
  worlds.lights.clear();
  Renderer still(scene, testDevice(), "studio");
  const std::vector<Frame> frames = renderer.render(worlds, o);
  for (size_t i = 0; i < 2; ++i) test::expectSameFrames(frames[2 + i], still.render(worlds.cameras[i], o));
}

// The shadows of directional lights are those of the only world of another renderer whose maps the host fits, for all
// formats and filters, one or several cameras, and maps of one or several cascades.
void compareShadows(const Options& o, double distance) {
  constexpr uint32_t kSome = 6, kCameras = 2;
  Scene scene("builtin:boxes");
  for (const Handle<Light>& light : scene.lights()) scene.removeLight(light);
  scene.addLight({.type = "directional", .direction = {0.3f, -1, 0.2f}, .intensity = 2});
  scene.addLight({.type = "point", .position = {0, 2, 0}, .intensity = 5, .castShadow = false});
  scene.addLight({.type = "directional", .direction = {-0.6f, -1, 0.1f}, .intensity = 1});
  Worlds worlds{.count = kSome, .instances = scene.instances()};
  for (uint32_t i = 0; i < kCameras; ++i)
    worlds.cameras.push_back(scene.lookAt({distance, 1.5 + i, distance}, {0, 0, 0}));
  worlds.cameras[1].orthographic = distance > 20;
  worlds.cameras[1].halfHeight = 3;
  worlds.cameras[1].farClip = 100;
  std::mt19937 random(13);
  const size_t listed = worlds.instances.size();
  std::vector<Transform> transforms;
  for (size_t i = 0; i < kSome * listed; ++i) {
    transforms.push_back(product(scene.instance(worlds.instances[i % listed]).transform, randomMotion(random, false)));
    worlds.exists.push_back(random() % 6 != 0);
  }
  const Numbers moved(transforms, true, 4);
  worlds.arrays.transforms = moved.array;
  Renderer renderer(scene, testDevice(), "studio"), alone(scene, testDevice(), "studio");
  Options unshadowed = o;
  unshadowed.shadows = "none";
  bool differs = false;
  for (int call = 0; call < 3; ++call) {
    const std::vector<Frame> frames = renderer.render(worlds, o);
    ASSERT_EQ(frames.size(), kSome * kCameras);
    const std::vector<Frame> lit = renderer.render(worlds, unshadowed);
    for (uint32_t world = 0; world < kSome && !testing::Test::HasFailure(); ++world) {
      Worlds one{.count = 1, .instances = worlds.instances, .cameras = worlds.cameras};
      // Values of lights, which equal the scene's, have the host plan the maps.
      one.lights = scene.lights();
      for (const Handle<Light>& light : one.lights) one.lightValues.push_back(scene.light(light));
      one.transforms.assign(transforms.begin() + static_cast<std::ptrdiff_t>(world * listed),
                            transforms.begin() + static_cast<std::ptrdiff_t>((world + 1) * listed));
      one.exists.assign(worlds.exists.begin() + static_cast<std::ptrdiff_t>(world * listed),
                        worlds.exists.begin() + static_cast<std::ptrdiff_t>((world + 1) * listed));
      const std::vector<Frame> expected = alone.render(one, o);
      for (uint32_t i = 0; i < kCameras; ++i) {
        SCOPED_TRACE(testing::Message() << "world " << world << ", camera " << i << ", call " << call);
        const size_t at = kCameras * world + i;
        test::expectSameFrames(frames[at], expected[i]);
        differs |= frames[at].rgba != lit[at].rgba;
      }
    }
  }
  EXPECT_TRUE(differs) << "something is in the shadow";
}

TEST(PlacedWorlds, CastShadows) {
  const std::tuple<double, const char*, const char*> cases[] = {
      {2.5, "d32", "pcf"}, {2.5, "rgba8-classic", "hard"}, {40.0, "d16", "pcss"}};
  for (const auto& [distance, format, filter] : cases) {
    SCOPED_TRACE(testing::Message() << format << ", " << distance);
    Options o = options("compute");
    o.width = 40;
    o.height = 30;
    o.shadows = format;
    o.shadowFilter = filter;
    o.aovs = {"color", "depth"};
    compareShadows(o, distance);
  }
}

// A point light, a spot light with one map and one that requires a cube, a sun, and lights without shadows or effect on
// the view, some of which are lights of a fixture that surrounds them.
void addLampsWithShadows(Scene& scene) {
  for (const Handle<Light>& light : scene.lights()) scene.removeLight(light);
  scene.addLight({.type = "point", .position = {1, 2, 1}, .intensity = 8});
  scene.addLight({.type = "spot", .position = {-1, 3, 1}, .direction = {0.3f, -1, -0.3f}, .intensity = 40});
  scene.addLight({.type = "point", .position = {0, 2, 2}, .intensity = 4, .castShadow = false});
  scene.addLight({.type = "spot",
                  .position = {1, 1.5, -1},
                  .direction = {-1, -0.4f, 1},
                  .intensity = 9,
                  .outerCone = 80,
                  .size = 0.1});
  scene.addLight({.type = "directional", .direction = {-0.6f, -1, 0.1f}, .intensity = 1});
  scene.addLight({.type = "point", .position = {-9, 1, -9}, .intensity = 8, .range = 0.5});
  scene.addLight({.type = "point", .position = {2, 1, -1}, .intensity = 8, .range = 4});
}

// Worlds under lights with shadow maps, of which each view has its own sizes and cube faces, are the edited scene.
TEST_P(ArraysOfWorlds, CastShadowsOfLocalLights) {
  const bool compute = std::string(GetParam()) == "compute";
  const uint32_t kSome = compute ? latelight::test::rounds(200u, 12u) : 6;
  Scene scene("builtin:boxes"), edited("builtin:boxes");
  addLampsWithShadows(scene);
  addLampsWithShadows(edited);
  Worlds worlds{.count = kSome, .instances = scene.instances()};
  worlds.cameras = {scene.lookAt({3, 2, 4}, {0, 0, 0}), scene.lookAt({-2, 3, 2}, {0, 0, 0})};
  worlds.cameras[1].orthographic = true;
  worlds.cameras[1].halfHeight = 2;
  worlds.cameras[1].farClip = 100;
  const size_t listed = worlds.instances.size();
  std::mt19937 random(23);
  std::uniform_real_distribution<double> nearer(0.2, 3);
  std::vector<Transform> transforms, poses;
  for (size_t i = 0; i < kSome * listed; ++i)
    transforms.push_back(
        asFloats(product(scene.instance(worlds.instances[i % listed]).transform, randomMotion(random, false))));
  for (size_t i = 0; i < 2 * kSome; ++i) {  // at different distances, for maps of all sizes
    Transform pose = product(worlds.cameras[i % 2].cameraToWorld, randomMotion(random, true));
    for (const size_t axis : {3, 7, 11}) pose[axis] *= nearer(random);
    poses.push_back(asFloats(pose));
  }
  const Numbers moved(transforms, true, 4), seen(poses, false, 3);
  worlds.arrays = {.transforms = moved.array, .cameraToWorld = seen.array};
  Options o = options(GetParam());
  o.width = 40;
  o.height = 30;
  o.aovs = {"color"};
  Options unshadowed = o;
  for (const char* format : {"d32", "d16"}) {
    o.shadows = format;
    o.shadowFilter = std::string(format) == "d16" ? "pcss" : "pcf";
    Renderer renderer(scene, testDevice(), "studio"), alone(edited, testDevice(), "studio");
    const std::vector<Frame> lit = renderer.render(worlds, unshadowed);
    size_t shadowed = 0;
    for (int call = 0; call < 3; ++call) {  // the third one is a replay, if shaders fit the maps
      const std::vector<Frame> frames = renderer.render(worlds, o);
      ASSERT_EQ(frames.size(), 2 * kSome);
      for (uint32_t world = 0; world < kSome && !HasFailure(); world += call == 1 ? 1 : 7) {
        for (size_t i = 0; i < listed; ++i) edited.setTransform(edited.instances()[i], transforms[world * listed + i]);
        for (size_t i = 0; i < 2; ++i) {
          SCOPED_TRACE(testing::Message() << format << ", world " << world << ", camera " << i << ", call " << call);
          Camera camera = worlds.cameras[i];
          camera.cameraToWorld = poses[2 * world + i];
          test::expectSameFrames(frames[2 * world + i], alone.render(camera, o));
          shadowed += frames[2 * world + i].rgba != lit[2 * world + i].rgba ? 1 : 0;
        }
      }
    }
    EXPECT_GT(shadowed, kSome / 2) << "something is in the shadow";
  }
}

// Results on the device are rendered in larger groups than those that the host reads, and in the third call on, by
// recorded commands. All of them have the same bytes.
TEST(PlacedWorlds, AreTheSameInLargeGroups) {
  constexpr uint32_t kMany = 700;
  Scene scene(models::modelPath("textured.glb").string());
  Renderer renderer(scene, testDevice());
  Worlds worlds{.count = kMany, .instances = {scene.instances()[0]}, .cameras = {scene.defaultCamera(4.0f / 3)}};
  std::mt19937 random(6);
  for (uint32_t world = 0; world < kMany; ++world) {
    worlds.transforms.push_back(product(scene.instance(worlds.instances[0]).transform, randomMotion(random, false)));
    worlds.environmentRotation.push_back(360.0 * world / kMany);
    worlds.environmentIntensity.push_back(0.5f + static_cast<float>(world) / kMany);
  }
  Options o = options("compute");
  o.width = 12;
  o.height = 9;
  o.aovs = {"depth", "id"};
  const std::vector<Frame> frames = renderer.render(worlds, o);
  for (int call = 0; call < 4; ++call) {
    std::map<std::string, DeviceArray> arrays = renderer.submit(worlds, o, Results::Arrays).takeArrays();
    std::vector<std::byte> rgba(kMany * 4 * o.width * o.height), depth(rgba.size());
    arrays.at("rgba").copyToHost(rgba);
    arrays.at("depth").copyToHost(depth);
    for (uint32_t world = 0; world < kMany && !HasFailure(); ++world) {
      const size_t bytes = 4 * o.width * o.height;
      EXPECT_EQ(std::memcmp(rgba.data() + world * bytes, frames[world].rgba.data(), bytes), 0) << world;
      EXPECT_EQ(std::memcmp(depth.data() + world * bytes, frames[world].aovs.at("depth").values.data(), bytes), 0)
          << world;
    }
  }
}

// Shaders find wrong values after submit() has returned.
TEST(PlacedWorlds, ReportWrongValuesWhenTaken) {
  Scene scene(models::modelPath("blended.glb").string());
  Renderer renderer(scene, testDevice());
  Worlds worlds{.count = 2, .instances = {scene.instances()[0]}, .cameras = {scene.defaultCamera(1.0f)}};
  worlds.transforms.assign(2, scene.instance(worlds.instances[0]).transform);
  worlds.transforms[1][12] = 1;
  Ticket ticket = renderer.submit(worlds, options("compute"));
  EXPECT_THROW(ticket.take(), Error);
  worlds.transforms[1][12] = 0;
  EXPECT_EQ(renderer.render(worlds, options("compute")).size(), 2u);
}

TEST(PlacedWorlds, AreChecked) {
  Scene scene(models::modelPath("blended.glb").string());
  Renderer renderer(scene, testDevice());
  const float numbers[64] = {};
  const auto refused = [&](const WorldArrays& arrays) {
    Worlds worlds{.count = 2, .instances = {scene.instances()[0]}, .cameras = {scene.defaultCamera(1.0f)}};
    worlds.arrays = arrays;
    worlds.cameraToWorld.assign(2, worlds.cameras[0].cameraToWorld);
    return rejectionOf([&] { renderer.render(worlds, options("compute")); });
  };
  using testing::HasSubstr;
  EXPECT_THAT(refused({.transforms = {.rows = 2, .host = numbers}}), HasSubstr("must have 3 or 4 rows, not 2"));
  EXPECT_THAT(refused({.exists = {.host = numbers}}), HasSubstr("exists must have elements of the type Uint8"));
  EXPECT_THAT(refused({.transforms = {.element = WorldArray::Element::Uint8, .host = numbers}}),
              HasSubstr("Float32 or Float64"));
  EXPECT_THAT(refused({.transforms = {.host = numbers, .offset = 8}}),
              HasSubstr("Worlds::arrays.transforms must begin at a multiple of 16 bytes"));
  EXPECT_THAT(refused({.transforms = {.host = numbers, .device = std::make_shared<DeviceArray>()}}),
              HasSubstr("Worlds::arrays.transforms must be in one memory only"));
  EXPECT_THAT(refused({.cameraToWorld = {.host = numbers}}), HasSubstr("describe the same: omit one of them"));
  EXPECT_THAT(refused({.previousTransforms = {.host = numbers}}), HasSubstr("require transforms"));
  EXPECT_THAT(refused({.lightColor = {.host = numbers}}), HasSubstr("require Worlds::lights"));
  EXPECT_THAT(refused({.materialChoice = {.host = numbers}}), HasSubstr("Int32 or Int64"));
  EXPECT_THAT(refused({.materialChoice = {.element = WorldArray::Element::Int32, .host = numbers}}),
              HasSubstr("require each other"));
}

// Every array that memory of the renderer may hold, with the bytes of 16 worlds as WorldArrays describes them.
struct SizedArray {
  const char* name;
  WorldArray WorldArrays::*array;
  uint64_t numbers;  // per world
  WorldArray::Element element = WorldArray::Element::Float32;
  uint32_t rows = 4;

  uint64_t bytes() const {
    using enum WorldArray::Element;
    return 16 * numbers * (element == Uint8 ? 1 : element == Float64 || element == Int64 ? 8 : 4);
  }
};

TEST(PlacedWorlds, RejectArraysThatExtendBeyondTheirMemory) {
  using enum WorldArray::Element;
  Scene scene(models::modelPath("skinned.glb").string());
  scene.addLight(Light{.name = "lamp"});
  Renderer renderer(scene, testDevice());
  if (!renderer.inputArray(16)->host()) GTEST_SKIP() << "the host writes no memory of this device";
  Worlds worlds{.count = 16, .instances = scene.instances(), .cameras = {2, scene.defaultCamera(1.0f)}};
  worlds.palette = {scene.materials()[0]};
  worlds.lights = scene.lights();
  worlds.environments = {"studio"};
  worlds.joints = scene.joints(worlds.instances[0]);
  worlds.meshes = {scene.meshes()[0]};
  using A = WorldArrays;
  const uint64_t instances = worlds.instances.size(), lights = worlds.lights.size(), joints = worlds.joints.size();
  const uint64_t vertices = scene.mesh(worlds.meshes[0]).vertices;
  const SizedArray all[] = {
      {"transforms", &A::transforms, 16 * instances, Float64},
      {"previousTransforms", &A::previousTransforms, 12 * instances, Float32, 3},
      {"nextTransforms", &A::nextTransforms, 12 * instances, Float64, 3},
      {"exists", &A::exists, instances, Uint8},
      {"cameraToWorld", &A::cameraToWorld, 16 * 2},
      {"previousCameraToWorld", &A::previousCameraToWorld, 16 * 2, Float64},
      {"nextCameraToWorld", &A::nextCameraToWorld, 12 * 2, Float32, 3},
      {"intrinsics", &A::intrinsics, 9 * 2, Float64},
      {"baseColor", &A::baseColor, 4 * instances},
      {"metallic", &A::metallic, instances},
      {"roughness", &A::roughness, instances, Float64},
      {"emissive", &A::emissive, 3 * instances},
      {"materialChoice", &A::materialChoice, instances, Int64},
      {"lightPosition", &A::lightPosition, 3 * lights, Float64},
      {"lightDirection", &A::lightDirection, 3 * lights},
      {"lightColor", &A::lightColor, 3 * lights},
      {"lightIntensity", &A::lightIntensity, lights},
      {"environmentRotation", &A::environmentRotation, 1, Float64},
      {"environmentIntensity", &A::environmentIntensity, 1},
      {"environmentIndex", &A::environmentIndex, 1, Int32},
      {"jointTransforms", &A::jointTransforms, 16 * joints},
      {"previousJointTransforms", &A::previousJointTransforms, 12 * joints, Float64, 3},
      {"nextJointTransforms", &A::nextJointTransforms, 16 * joints},
      {"vertices", &A::vertices, 3 * vertices},
      {"previousVertices", &A::previousVertices, 3 * vertices, Float64},
      {"nextVertices", &A::nextVertices, 3 * vertices},
  };
  for (const SizedArray& each : all)
    worlds.arrays.*
        each.array = {.element = each.element, .rows = each.rows, .device = renderer.inputArray(each.bytes())};
  const auto resultOf = [&](const SizedArray& each, uint64_t bytes, uint64_t offset) {
    Worlds changed = worlds;
    changed.arrays.*each.array = {
        .element = each.element, .rows = each.rows, .device = renderer.inputArray(bytes), .offset = offset};
    return rejectionOf([&] { renderer.render(changed, options("compute")); });
  };
  // The memory holds no transforms, which is reported later than its size.
  const auto rejected = testing::HasSubstr("extend beyond its memory");
  for (const SizedArray& each : all) {
    SCOPED_TRACE(each.name);
    EXPECT_THAT(resultOf(each, each.bytes(), 0), testing::Not(rejected));
    EXPECT_THAT(resultOf(each, each.bytes() + 32, 32), testing::Not(rejected));
    for (const auto& [bytes, offset] : {std::pair{each.bytes() - 16, uint64_t{0}},
                                        {each.bytes(), 16},
                                        {each.bytes(), uint64_t{1} << 40},
                                        {each.bytes(), ~uint64_t{0} - 15}}) {
      const std::string message = resultOf(each, bytes, offset);
      EXPECT_THAT(message, rejected) << bytes << ' ' << offset;
      EXPECT_THAT(message, testing::StartsWith("Worlds::arrays." + std::string(each.name) + " "));
    }
  }
  // With so many worlds, the number of bytes of the vertices is larger than 2^64.
  worlds.count = ~0u;
  worlds.meshes.assign(size_t{1} << 22, worlds.meshes[0]);
  worlds.arrays = {.vertices = worlds.arrays.vertices};
  worlds.joints.clear(), worlds.palette.clear(), worlds.environments.clear();
  EXPECT_THAT(rejectionOf([&] { renderer.render(worlds, options("compute")); }), rejected);
}

}  // namespace
}  // namespace latelight
