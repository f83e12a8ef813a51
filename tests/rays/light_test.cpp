// Shadows by rays and light between surfaces, against closed forms.
#include <fmt/core.h>

#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "base/error.h"
#include "long_tests.h"
#include "render/support.h"
#include "scene/scene_builder.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;
using output::Aov;

constexpr float kPi = std::numbers::pi_v<float>;

uint32_t addMaterial(scene::Scene& scene, vec3 color, vec3 emissive = vec3(0)) {
  scene::Material material;
  material.data.baseColor = glm::vec4(color, 1);
  material.data.emissive = emissive;
  material.data.roughness = 1;
  material.data.specular = 0;  // Lambertian
  material.data.specularColor = vec3(1);
  material.data.id = static_cast<uint32_t>(scene.materials.size()) + 1;
  material.data.flags = shared::kMaterialDoubleSided;
  scene.materials.push_back(material);
  return static_cast<uint32_t>(scene.materials.size()) - 1;
}

// A box [-1, 1]^3 with flat normals.
scene::Mesh boxMesh() {
  scene::Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      for (int i = 0; i < 4; ++i) {
        vec3 position(side), normal(0);
        position[(axis + 1) % 3] = i & 1 ? 1.0f : -1.0f;
        position[(axis + 2) % 3] = i & 2 ? 1.0f : -1.0f;
        normal[axis] = side;
        mesh.positions.push_back(position);
        mesh.attributes.push_back({normal, glm::vec4(0), glm::vec2(0)});
      }
      if (side > 0)
        mesh.indices.insert(mesh.indices.end(), {first, first + 1, first + 2, first + 1, first + 3, first + 2});
      else
        mesh.indices.insert(mesh.indices.end(), {first, first + 2, first + 1, first + 1, first + 2, first + 3});
    }
  scene::findBounds(mesh);
  return mesh;
}

// A white floor in the plane z = 0 of the renderer's world, below a box or a sphere, lit by one light, seen from above.
struct FloorScene {
  scene::SceneBuilder builder{"floor"};
  scene::Camera camera;
  uint32_t size = 96;

  FloorScene(scene::Mesh occluder, const glm::dmat4& placed, const scene::Light& light) {
    scene::Scene& scene = builder.scene;
    const uint32_t white = addMaterial(scene, vec3(1));
    scene.meshes = {squareMesh(), std::move(occluder)};
    for (uint32_t mesh = 0; mesh < 2; ++mesh) {
      scene::findBounds(scene.meshes[mesh]);
      builder.addInstance(mesh ? "occluder" : "floor", builder.kRoot, mesh, white, glm::mat4(1));
      scene.instances[mesh].toWorld = glm::dmat4(1);
    }
    scene.instances[0].toWorld[0].x = scene.instances[0].toWorld[1].y = 4;
    scene.instances[1].toWorld = placed;
    scene.lights.push_back(light);
    camera.orthographic = true;
    camera.yHalf = 4;
    camera.nearClip = 0.5f;
    camera.farClip = 100;
    // Looks down: right is +X, up in the image is +Y.
    camera.toWorld[1] = glm::dvec4(0, 0, -1, 0);
    camera.toWorld[2] = glm::dvec4(0, 1, 0, 0);
    camera.toWorld[3] = glm::dvec4(0, 0, 50, 1);
  }

  Settings settings() const {
    Settings s = settingsOf(size, size, {Aov::Color, Aov::Position});
    s.axes = Axes::ZUp;
    s.shadows = ShadowFormat::Rays;
    return s;
  }
  dvec2 place(uint32_t x, uint32_t y) const { return dvec2((x + 0.5) / size * 2 - 1, 1 - (y + 0.5) / size * 2) * 4.0; }
};

class RayLightTest : public RenderTest {
 protected:
  // Returns the fraction of the light that reaches each pixel of the floor, or -1 where the occluder covers it.
  static std::vector<float> litFractions(const FloorScene& floor, const Settings& settings) {
    Settings without = settings;
    without.shadows = ShadowFormat::None;
    const output::FrameOutput shadowed = renderOne(device(), floor.builder.scene, floor.camera, settings);
    const output::FrameOutput lit = renderOne(device(), floor.builder.scene, floor.camera, without);
    std::vector<float> fractions;
    for (size_t i = 0; i < size_t{floor.size} * floor.size; ++i) {
      const bool covered = vec3At(imageOf(lit, Aov::Position), i).z > 1e-3f;
      fractions.push_back(
          covered ? -1 : imageOf(shadowed, Aov::Color).values[4 * i] / imageOf(lit, Aov::Color).values[4 * i]);
    }
    return fractions;
  }
};

scene::Light sunFrom(dvec3 toLight) {
  scene::Light light;
  light.type = shared::kLightDirectional;
  light.intensity = kPi;
  light.direction = -vec3(glm::normalize(toLight));
  return light;
}

// A point of the floor is in shadow if its ray toward the sun passes nearer to the sphere's center than its radius. The
// mesh lies between the sphere and a smaller one.
TEST_F(RayLightTest, ASphereCastsItsShadow) {
  const dvec3 center(-0.4, 0.3, 1.7), toLight = glm::normalize(dvec3(0.5, -0.3, 1));
  glm::dmat4 placed(1);
  placed[3] = glm::dvec4(center, 1);
  const FloorScene floor(sphereMesh(1), placed, sunFrom(toLight));
  const std::vector<float> lit = litFractions(floor, floor.settings());
  const double inner = std::cos(std::numbers::pi / 16) - 1e-3;  // of the coarser direction
  size_t dark = 0, bright = 0;
  for (uint32_t i = 0; i < lit.size(); ++i) {
    if (lit[i] < 0) continue;
    const dvec3 to = center - dvec3(floor.place(i % floor.size, i / floor.size), 0);
    const double distance = glm::length(to - toLight * glm::dot(to, toLight));
    dark += distance < inner;
    bright += distance > 1 + 1e-3;
    if (distance < inner || distance > 1 + 1e-3) {
      EXPECT_EQ(lit[i], distance < inner ? 0 : 1) << i;
    }
  }
  EXPECT_GT(dark, 100u);
  EXPECT_GT(bright, 6000u);
}

// Irradiance pi below the sun on a white Lambertian floor is radiance 1, and 0 in the shadow, with each technique.
TEST_F(RayLightTest, TechniquesOmitLightsWithShadows) {
  glm::dmat4 placed(1);
  placed[3] = glm::dvec4(0, 0, 1.7, 1);
  FloorScene floor(boxMesh(), placed, sunFrom({0, 0, 1}));
  floor.size = 16;
  for (const char* technique : {"fullscreen", "volumes", "tiled", "clustered"}) {
    Settings s = floor.settings();
    s.lighting = &findTechnique(technique);
    const output::FrameOutput seen = renderOne(device(), floor.builder.scene, floor.camera, s);
    EXPECT_NEAR(imageOf(seen, Aov::Color).values[0], 1, 2e-3) << technique;
    const std::vector<float> lit = litFractions(floor, s);
    EXPECT_EQ(lit[0], 1) << technique;
  }
}

// A point light below the sphere's side: the shadow is a cone's section.
TEST_F(RayLightTest, PointAndSpotLightsCastSharpShadows) {
  for (const uint32_t type : {shared::kLightPoint, shared::kLightSpot}) {
    const dvec3 center(0.2, -0.3, 1.3), position(1.1, 0.4, 3.5);
    scene::Light light;
    light.type = type;
    light.intensity = 20;
    light.position = position;
    light.direction = vec3(glm::normalize(center - position));
    light.outerCone = 1.2f;
    glm::dmat4 placed(0.6);
    placed[3] = glm::dvec4(center, 1);
    const FloorScene floor(sphereMesh(1), placed, light);
    const std::vector<float> lit = litFractions(floor, floor.settings());
    const double inner = 0.6 * std::cos(std::numbers::pi / 16) - 1e-3;
    size_t dark = 0;
    for (uint32_t i = 0; i < lit.size(); ++i) {
      if (!(lit[i] >= 0)) continue;  // covered, or outside the cone
      const dvec3 from(floor.place(i % floor.size, i / floor.size), 0), to = center - from;
      const dvec3 toLight = glm::normalize(position - from);
      const double distance = glm::length(to - toLight * glm::dot(to, toLight));
      dark += distance < inner;
      if (distance < inner || distance > 0.6 + 1e-3) {
        EXPECT_EQ(lit[i], distance < inner ? 0 : 1) << i;
      }
    }
    EXPECT_GT(dark, 100u);
  }
}

// Behind a straight edge, the visible part of the sun's disk is a segment of a circle.
TEST_F(RayLightTest, AStraightEdgeHasThePenumbraOfADisk) {
  scene::Light sun = sunFrom({0, 0, 1});
  sun.size = 0.2f;  // angular diameter
  glm::dmat4 placed(1);
  placed[0].x = placed[1].y = 20;  // covers x > 0 at the height of 4 m
  placed[2].z = 0.01;
  placed[3] = glm::dvec4(20, 0, 4, 1);
  FloorScene floor(boxMesh(), placed, sun);
  floor.camera.toWorld[3].z = 3.5;  // below the occluder
  floor.camera.nearClip = 0.1f;
  Settings settings = floor.settings();
  settings.samples = 256;
  const std::vector<float> lit = litFractions(floor, settings);
  const double radius = 3.99 * std::tan(0.1);
  double worst = 0, mean = 0;
  for (uint32_t i = 0; i < lit.size(); ++i) {
    const double x = std::clamp(-floor.place(i % floor.size, i / floor.size).x / radius, -1.0, 1.0);
    const double expected = 1 - (std::acos(x) - x * std::sqrt(1 - x * x)) / std::numbers::pi;
    worst = std::max(worst, std::abs(lit[i] - expected));
    mean += lit[i] - expected;
  }
  EXPECT_LT(worst, 0.03);
  EXPECT_LT(std::abs(mean) / static_cast<double>(lit.size()), 1e-3);
}

float meanColor(const output::FrameOutput& frame) {
  const std::vector<float>& values = imageOf(frame, Aov::Color).values;
  double sum = 0, pixels = 0;
  for (size_t i = 0; i < values.size(); i += 4)
    if (values[i + 3] == 1) sum += (values[i] + values[i + 1] + values[i + 2]) / 3, ++pixels;
  return static_cast<float>(sum / pixels);
}

// A lamp encloses its light: a box within the light's radius is the light's own body, and a larger one is not.
TEST_F(RayLightTest, TheBodyOfALightBlocksNoneOfIt) {
  scene::Light light;
  light.type = shared::kLightPoint;
  light.intensity = 20;
  light.position = dvec3(0, 0, 2);
  light.size = 0.3f;
  for (const char* technique : {"fullscreen", "reference"})
    for (const double half : {0.15, 0.5}) {
      glm::dmat4 placed(half);
      placed[3] = glm::dvec4(0, 0, 2, 1);
      FloorScene floor(boxMesh(), placed, light);
      floor.camera.toWorld[3].z = 1.2;  // below the box
      floor.camera.nearClip = 0.1f;
      Settings settings = floor.settings();
      settings.width = settings.height = floor.size = 16;
      settings.samples = 64;
      settings.lighting = &findTechnique(technique);
      const float color = meanColor(renderOne(device(), floor.builder.scene, floor.camera, settings));
      if (half < 0.2) {
        EXPECT_GT(color, 0.2f) << technique;
      }
      if (half > 0.2) {
        EXPECT_EQ(color, 0) << technique;
      }
    }
}

TEST_F(RayLightTest, RefusesMoreRaysThanACpuCanLoopOver) {
  if (!device().isCpu()) GTEST_SKIP() << "GPUs have no such limit";
  scene::Light sun = sunFrom({0, 0, 1});
  sun.size = 0.2f;
  const FloorScene floor(boxMesh(), glm::dmat4(1), sun);
  Settings settings = floor.settings();
  settings.samples = 257;
  EXPECT_THROW(renderOne(device(), floor.builder.scene, floor.camera, settings), Error);
}

// The limit is that of each light: radiance of two lights with 200 rays each is the sum of both lights'.
TEST_F(RayLightTest, EachLightMayHaveAsManyRaysAsACpuCanLoopOver) {
  glm::dmat4 placed(0.5);
  placed[3] = glm::dvec4(0, 0, 1.5, 1);
  scene::Light left = sunFrom({-1, 0, 2}), right = sunFrom({1, 0.5, 2});
  left.size = right.size = 0.2f;
  const auto radianceOf = [&](std::initializer_list<scene::Light> lights) {
    FloorScene floor(boxMesh(), placed, left);
    floor.size = 48;
    floor.builder.scene.lights = lights;
    Settings settings = floor.settings();
    settings.samples = 200;
    return imageOf(renderOne(device(), floor.builder.scene, floor.camera, settings), Aov::Color).values;
  };
  const std::vector<float> both = radianceOf({left, right}), ofLeft = radianceOf({left}), ofRight = radianceOf({right});
  size_t dark = 0;
  for (size_t i = 0; i < both.size(); ++i) {
    if (i % 4 == 3) continue;
    EXPECT_NEAR(both[i], ofLeft[i] + ofRight[i], 2e-3f * both[i]) << i;  // lit in halves
    dark += ofLeft[i] == 0;
  }
  EXPECT_GT(dark, 30u);
}

// Lights of pi lux in total give a white floor the radiance 1, however many they are, although some devices round half
// floats down.
TEST_F(RayLightTest, TheLightOfManyLightsIsTheirSum) {
  for (const float size : {0.0f, 0.01f})
    for (const size_t count : {size_t{5}, size_t{256}}) {
      scene::Light sun = sunFrom({0, 0, 1});
      sun.intensity = kPi / static_cast<float>(count);
      sun.size = size;
      FloorScene floor(boxMesh(), glm::dmat4(1), sun);
      floor.builder.scene.instances.pop_back();
      floor.builder.scene.lights.assign(count, sun);
      Settings settings = floor.settings();
      settings.width = settings.height = 8;
      settings.shadowLights = {.automatic = false, .most = ShadowLights::kAll, .names = {}};
      settings.samples = 20;
      const output::FrameOutput frame = renderOne(device(), floor.builder.scene, floor.camera, settings);
      EXPECT_NEAR(meanColor(frame), 1, 1.5e-3) << count << " lights of size " << size;
    }
}

TEST_F(RayLightTest, ViewsWithOtherLightsHaveTheLightOfViewsAlone) {
  glm::dmat4 placed(0.3);
  placed[3] = glm::dvec4(0, 0, 0.6, 1);
  scene::Light lamp = sunFrom({0, 0, 1});
  lamp.type = shared::kLightPoint;
  lamp.intensity = 0.7f;
  lamp.range = 2.5f;
  FloorScene floor(boxMesh(), placed, lamp);
  std::vector<scene::Light>& lights = floor.builder.scene.lights;
  lights.clear();
  for (int i = 0; i < 24; ++i) {
    lamp.position = dvec3(0.3 * i - 3.6, 0.2 * (i % 5) - 0.4, 1.5);
    lamp.size = i > 20 ? 0.2f : 0.0f;
    lights.push_back(lamp);
  }
  Settings settings = floor.settings();
  settings.width = settings.height = 24;
  settings.samples = 8;
  settings.shadowLights = {.automatic = false, .most = ShadowLights::kAll, .names = {}};
  scene::Camera left = floor.camera, right = floor.camera;
  left.yHalf = right.yHalf = 1;
  left.toWorld[3].x = -2.5;
  right.toWorld[3].x = 2.5;
  Renderer renderer(device(), floor.builder.scene, nullptr);
  const std::vector<scene::Camera> cameras = {left, floor.camera, right};
  const std::vector<output::FrameOutput> together = renderer.render(cameras, settings);
  for (size_t i = 0; i < cameras.size(); ++i) {
    const output::FrameOutput alone = renderOne(device(), floor.builder.scene, cameras[i], settings);
    EXPECT_GT(meanColor(alone), 0.1f);
    for (size_t k = 0; k < imageOf(alone, Aov::Color).values.size(); ++k)
      EXPECT_NEAR(imageOf(together[i], Aov::Color).values[k], imageOf(alone, Aov::Color).values[k], 1e-3f);
  }
}

// --- light between surfaces ------------------------------------------------------------------------------------------

// Inside a closed box whose walls emit e and reflect a fraction r, the radiance after n surfaces is the geometric
// series e (1 + r + ... + r^n) everywhere.
TEST_F(RayLightTest, AClosedBoxIsAGeometricSeries) {
  scene::SceneBuilder builder("box");
  builder.scene.meshes.push_back(boxMesh());
  builder.addInstance("box", builder.kRoot, 0, addMaterial(builder.scene, vec3(0.5f), vec3(0.5f)), glm::mat4(1));
  builder.scene.instances[0].toWorld = glm::dmat4(1);
  scene::Camera camera;
  camera.verticalFov = 1.2f;
  camera.toWorld[3] = glm::dvec4(0.1, -0.3, 0.2, 1);
  Settings settings = settingsOf(32, 32, {Aov::Color});
  settings.samples = 64;
  settings.indirect = Indirect::OneBounce;
  EXPECT_NEAR(meanColor(renderOne(device(), builder.scene, camera, settings)), 0.75f, 1e-3f);
  settings.indirect = Indirect::Path;
  EXPECT_NEAR(meanColor(renderOne(device(), builder.scene, camera, settings)), 1, 3e-3f);
  settings.indirect = Indirect::None;
  settings.lighting = &findTechnique("reference");
  EXPECT_NEAR(meanColor(renderOne(device(), builder.scene, camera, settings)), 1, 3e-3f);
}

// White furnace: under a uniform environment, a white surface of any material is as bright as the environment.
TEST_F(RayLightTest, WhiteSurfacesVanishInAFurnace) {
  const scene::Environment environment = constantEnvironment();
  const bool full = latelight::test::runsInFull();
  for (const float metallic : {0.0f, 1.0f})
    for (const float roughness : {0.0f, 0.3f, 1.0f})
      for (const char* layout : {"exact", "visibility"}) {
        if (!full && (roughness == 0.3f) == (std::string(layout) == "exact")) continue;  // half of them
        scene::SceneBuilder builder("furnace");
        builder.scene.meshes.push_back(sphereMesh(1));
        scene::Scene& scene = builder.scene;
        builder.addInstance("sphere", builder.kRoot, 0, addMaterial(scene, vec3(1)), glm::mat4(1));
        scene.materials[0].data.metallic = metallic;
        scene.materials[0].data.roughness = roughness;
        scene.materials[0].data.specular = 1;
        scene.materials[0].data.f0 = 0.04f;
        Settings settings = settingsOf(32, 32, {Aov::Color});
        settings.layout = &findLayout(layout);
        settings.lighting = &findTechnique("reference");
        settings.samples = 128;
        settings = inTheirRaster(settings);
        const float mean = meanColor(renderOne(device(), scene, frontCamera(0.7f), settings, &environment));
        EXPECT_NEAR(mean, 1, 0.005f) << layout << " metallic " << metallic << " roughness " << roughness;
      }
}

// A smooth white metal reflects one direction, so each path has the environment's radiance.
// A flat surface receives no light from itself, whatever its shading normals are: below its plane, all is dark. In a
// uniform environment, a Lambertian surface with a normal that is tilted by t reflects (1 + cos t) / 2.
TEST_F(RayLightTest, SurfacesDoNotLightThemselves) {
  const scene::Environment environment = constantEnvironment();
  const auto compare = [&](float tilt, const char* layout, Indirect indirect) {
    SCOPED_TRACE(fmt::format("{} degrees, layout {}, indirect {}", tilt, layout, static_cast<int>(indirect)));
    const float cosine = std::cos(tilt * kPi / 180), sine = std::sin(tilt * kPi / 180);
    FloorScene floor(boxMesh(), glm::dmat4(1), sunFrom({0, 0, 1}));
    scene::Scene& scene = floor.builder.scene;
    scene.instances.pop_back();
    scene.materials[0].data.emissive = vec3(0.25f);
    for (auto& vertex : scene.meshes[0].attributes)
      vertex.normal = glm::normalize(vec3(0, 4 * sine, cosine));  // the floor is 4 times as long
    floor.size = 16;
    Settings settings = floor.settings();
    settings.layout = &findLayout(layout);
    settings.raster = Raster::Compute;
    settings.samples = 64;
    settings.indirect = indirect;
    if (indirect == Indirect::None) settings.lighting = &findTechnique("reference");
    const auto mean = [&](const scene::Environment* lit) {
      return meanColor(renderOne(device(), scene, floor.camera, settings, lit));
    };
    const double direct = 0.25 + cosine;
    EXPECT_NEAR(mean(nullptr), direct, 0.004);
    EXPECT_NEAR(mean(&environment), direct + (1 + cosine) / 2, 0.01);
  };
  for (const float tilt : {5.0f, 60.0f}) {
    for (const char* layout : {"compact", "exact", "visibility"}) compare(tilt, layout, Indirect::None);
    for (const Indirect indirect : {Indirect::OneBounce, Indirect::Path}) compare(tilt, "compact", indirect);
  }
}

TEST_F(RayLightTest, MirrorsInAUniformEnvironmentHaveNoNoise) {
  const scene::Environment environment = constantEnvironment();
  scene::SceneBuilder builder("mirror");
  builder.scene.meshes.push_back(sphereMesh(1));
  builder.addInstance("sphere", builder.kRoot, 0, addMaterial(builder.scene, vec3(1)), glm::mat4(1));
  builder.scene.materials[0].data.metallic = 1;
  builder.scene.materials[0].data.roughness = 0;
  Settings settings = settingsOf(32, 32, {Aov::Color});
  settings.lighting = &findTechnique("reference");
  settings.samples = 1;
  settings = inTheirRaster(settings);
  const output::FrameOutput frame = renderOne(device(), builder.scene, frontCamera(0.7f), settings, &environment);
  int noisy = 0;
  for (size_t i = 0; i < size_t{32} * 32; ++i) noisy += std::abs(imageOf(frame, Aov::Color).values[4 * i] - 1) > 0.02f;
  EXPECT_LT(noisy, 40);  // at the silhouette, interpolated normals point away
}

// The fraction of the cosine-weighted hemisphere that a parallel square of side 2 a subtends at height h above a point
// below its center: the form factor (4 / pi) a / sqrt(a^2 + h^2) atan(a / sqrt(a^2 + h^2)).
double formFactor(double a, double h) {
  const double side = a / std::hypot(a, h);
  return 4 / std::numbers::pi * side * std::atan(side);
}

// A white floor under a square that emits and reflects nothing, seen between both.
FloorScene floorBelowASquare(double half, double height, vec3 emissive) {
  scene::Light dark = sunFrom({0, 0, 1});
  glm::dmat4 placed(1);
  placed[0].x = placed[1].y = half;
  placed[3] = glm::dvec4(0, 0, height, 1);
  FloorScene floor(squareMesh(), placed, dark);
  scene::Scene& scene = floor.builder.scene;
  scene.lights.clear();
  scene.instances[1].material = addMaterial(scene, vec3(0), emissive);
  floor.camera.toWorld[3].z = 0.9 * height;
  floor.camera.nearClip = 0.01f;
  floor.camera.yHalf = 0.02f;
  return floor;
}

// With the directions of the floor's lobe only, 8 of 10 pixels would see no light of the smaller square.
TEST_F(RayLightTest, EmissiveTrianglesNeedNoLuck) {
  for (const double half : {0.02, 0.5}) {
    const FloorScene floor = floorBelowASquare(half, 1, vec3(static_cast<float>(1 / formFactor(half, 1))));
    Settings settings = floor.settings();
    settings.width = settings.height = 16;
    settings.samples = 16;
    for (const Indirect indirect : {Indirect::OneBounce, Indirect::Path}) {
      settings.indirect = indirect;
      const output::FrameOutput frame = renderOne(device(), floor.builder.scene, floor.camera, settings);
      EXPECT_NEAR(meanColor(frame), 1, 0.005) << half;
      for (size_t i = 0; i < 256; ++i) EXPECT_NEAR(imageOf(frame, Aov::Color).values[4 * i], 1, 0.25) << half;
    }
  }
}

// One white texel of 16 x 16 emits: 0.4 % of the square, near a corner, at the diagonal, and in one of both triangles.
TEST_F(RayLightTest, BrightTexelsNeedNoLuck) {
  constexpr int kTexels = 16;
  for (const glm::ivec2 texel : {glm::ivec2(15, 0), glm::ivec2(7, 8), glm::ivec2(3, 5), glm::ivec2(10, 14)}) {
    // Of a small square at an offset, with both cosines height / distance.
    const dvec2 offset = (dvec2(texel) + 0.5) / double{kTexels} - 0.5;
    const double factor = 1 / (kTexels * kTexels * std::numbers::pi * std::pow(1 + glm::dot(offset, offset), 2));
    FloorScene floor = floorBelowASquare(0.5, 1, vec3(static_cast<float>(1 / factor)));
    std::vector<glm::u8vec4> colors(kTexels * kTexels, glm::u8vec4(0, 0, 0, 255));
    colors[static_cast<size_t>(texel.y * kTexels + texel.x)] = glm::u8vec4(255);
    scene::Scene& scene = floor.builder.scene;
    scene.textures.push_back(textureOf(kTexels, kTexels, true, colors));
    test::setTexture(scene.materials.back(), shared::kTextureEmissive, 0, kNearest);
    scene.materials.back().data.transforms[shared::kTextureEmissive] = {vec3(1, 0, 0), vec3(0, 1, 0), 0};
    Settings settings = floor.settings();
    settings.width = settings.height = 16;
    settings.samples = 256;
    settings.lighting = &findTechnique("reference");
    const output::FrameOutput frame = renderOne(device(), scene, floor.camera, settings);
    EXPECT_NEAR(meanColor(frame), 1, 0.06) << texel.x << ' ' << texel.y;
    int dark = 0;
    for (size_t i = 0; i < 256; ++i) dark += imageOf(frame, Aov::Color).values[4 * i] < 0.1f;
    EXPECT_LT(dark, 64) << texel.x << ' ' << texel.y;
  }
}

// Neither the picture nor its raster has the blended square above the camera, which half of the paths pass.
TEST_F(RayLightTest, BlendedEmittersOutsideThePictureEmit) {
  FloorScene floor = floorBelowASquare(0.5, 1, vec3(static_cast<float>(1 / formFactor(0.5, 1))));
  scene::Material& blended = floor.builder.scene.materials.back();
  blended.data.flags |= shared::kMaterialBlended;
  blended.data.baseColor.a = 0.5f;
  Settings settings = floor.settings();
  settings.width = settings.height = 16;
  settings.samples = 128;
  settings.lighting = &findTechnique("reference");
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    settings.raster = raster;
    EXPECT_NEAR(meanColor(renderOne(device(), floor.builder.scene, floor.camera, settings)), 0.5, 0.01);
  }
}

// Two squares, one of which is four times as large and half as bright, at a distance at which both are small: the sum
// of their form factors.
TEST_F(RayLightTest, EmittersAddUp) {
  FloorScene floor = floorBelowASquare(0.1, 2, vec3(2));
  scene::Scene& scene = floor.builder.scene;
  floor.builder.addInstance("second", floor.builder.kRoot, 0, addMaterial(scene, vec3(0), vec3(1)), glm::mat4(1));
  scene.instances[2].toWorld = scene.instances[1].toWorld;
  scene.instances[2].toWorld[0].x = scene.instances[2].toWorld[1].y = 0.2;
  scene.instances[2].toWorld[3] = glm::dvec4(0, 0, 2.5, 1);  // partly behind the first
  Settings settings = floor.settings();
  settings.width = settings.height = 16;
  settings.samples = 64;
  settings.indirect = Indirect::OneBounce;
  // Seen from the floor, the first covers a square of side 2 * 0.125 at the height of the second.
  const double expected = 2 * formFactor(0.1, 2) + formFactor(0.2, 2.5) - formFactor(0.125, 2.5);
  EXPECT_NEAR(meanColor(renderOne(device(), scene, floor.camera, settings)) / expected, 1, 0.01);
}

// A Lambertian floor below an overcast sky of radiance 1 that a square blocks in part. With the filter, each ray is
// chosen among four directions.
TEST_F(RayLightTest, TheEnvironmentCastsShadows) {
  const FloorScene floor = floorBelowASquare(1.5, 1, vec3(0));
  const scene::Environment environment = constantEnvironment();
  Settings settings = floor.settings();
  settings.width = settings.height = 16;
  settings.samples = 256;
  settings.indirect = Indirect::OneBounce;
  for (const IndirectFilter filter : {IndirectFilter::None, IndirectFilter::Spatial}) {
    settings.indirectFilter = filter;
    EXPECT_NEAR(meanColor(renderOne(device(), floor.builder.scene, floor.camera, settings, &environment)),
                1 - formFactor(1.5, 1), 0.003);
  }
}

// A sky whose brightness varies with the longitude, and a sun with most of its light.
scene::FloatImage sunnySky() {
  scene::FloatImage sky(256, 128);
  for (uint32_t y = 0; y < sky.height; ++y)
    for (uint32_t x = 0; x < sky.width; ++x) {
      const float turn = (static_cast<float>(x) + 0.5f) / static_cast<float>(sky.width) * 2 * kPi;
      const bool sun = x / 4 == 10 && y / 4 == 7;
      std::fill_n(sky.at(x, y), 3, sun ? 400.0f : 0.5f + 0.45f * std::sin(3 * turn));
    }
  return sky;
}

// Irradiance / pi of a horizontal floor below a sky, whose texels are interpolated.
double radianceBelow(const scene::FloatImage& sky) {
  constexpr uint32_t kPoints = 8;
  const auto texel = [&](int x, int y) {
    const int width = static_cast<int>(sky.width), height = static_cast<int>(sky.height);
    return double{*sky.at((x + width) % width, std::clamp(y, 0, height - 1))};
  };
  double sum = 0;
  for (uint32_t y = 0; y < sky.height / 2 * kPoints; ++y)
    for (uint32_t x = 0; x < sky.width * kPoints; ++x) {
      const double u = (x + 0.5) / kPoints - 0.5, v = (y + 0.5) / kPoints - 0.5;
      const int column = static_cast<int>(std::floor(u)), row = static_cast<int>(std::floor(v));
      const double s = u - column, t = v - row;
      const double radiance = (1 - t) * ((1 - s) * texel(column, row) + s * texel(column + 1, row)) +
                              t * ((1 - s) * texel(column, row + 1) + s * texel(column + 1, row + 1));
      const double angle = (y + 0.5) / kPoints / sky.height * std::numbers::pi;  // from the zenith
      sum += radiance * std::cos(angle) * std::sin(angle);
    }
  const double step = std::numbers::pi / sky.height / kPoints;
  return sum * step * 2 * std::numbers::pi / sky.width / kPoints / std::numbers::pi;
}

// Points of the sample sequence remain well distributed among the directions of an environment. An alias table of the
// cells, which scatters them, has a standard deviation of 3.7 % here.
TEST_F(RayLightTest, SamplesOfEnvironmentsAreWellDistributed) {
  FloorScene floor(squareMesh(), glm::translate(glm::dmat4(1), dvec3(0, 0, -9)), scene::Light{.intensity = 0});
  floor.size = 32;
  const scene::FloatImage sky = sunnySky();
  scene::Environment environment = constantEnvironment();
  environment.radiance = scene::makeRadianceMap(sky, false);
  Settings settings = floor.settings();
  settings.samples = 256;
  settings.indirect = Indirect::OneBounce;
  const output::FrameOutput frame = renderOne(device(), floor.builder.scene, floor.camera, settings, &environment);
  const double expected = radianceBelow(sky);
  double mean = 0, square = 0;
  for (size_t i = 0; i < 32 * 32; ++i) {
    const double ratio = imageOf(frame, Aov::Color).values[4 * i] / expected;
    mean += ratio / (32 * 32);
    square += (ratio - 1) * (ratio - 1) / (32 * 32);
  }
  EXPECT_NEAR(mean, 1, 0.002);
  EXPECT_LT(std::sqrt(square), 0.02);
  settings.indirectFilter = IndirectFilter::Spatial;
  const output::FrameOutput filtered = renderOne(device(), floor.builder.scene, floor.camera, settings, &environment);
  EXPECT_NEAR(meanColor(filtered) / expected, 1, 0.002);
}

// A floor beside a glossy wall that reflects the sky toward it. With an area light, however dark it is, the path goes
// on from the wall. Without one, the direction in which it would go on is a candidate of the wall's ray to the sky.
TEST_F(RayLightTest, LastSurfacesReflectTheSky) {
  const scene::FloatImage sky = sunnySky();
  scene::Environment environment = constantEnvironment();
  environment.radiance = scene::makeRadianceMap(sky, false);
  for (const float roughness : {0.15f, 0.5f}) {
    const auto seen = [&](bool goesOn) {
      const glm::dmat4 wall(glm::dvec4(0, 1, 0, 0), glm::dvec4(0, 0, 1, 0), glm::dvec4(1, 0, 0, 0),
                            glm::dvec4(-0.5, 0, 0, 1));
      FloorScene floor(squareMesh(), wall, scene::Light{.intensity = 0});
      scene::Scene& scene = floor.builder.scene;
      scene.instances[1].material = addMaterial(scene, vec3(1));
      scene::Material& metal = scene.materials.back();
      metal.data.metallic = 1;
      metal.data.roughness = roughness;
      metal.data.specular = 1;
      scene::Light dark;
      dark.type = shared::kLightSphere;
      dark.size = 0.01f;
      dark.intensity = 1e-20f;
      if (goesOn) scene.lights.push_back(dark);
      floor.size = 32;
      floor.camera.yHalf = 0.1f;
      Settings settings = floor.settings();
      settings.samples = 128;
      settings.indirect = Indirect::OneBounce;
      return meanColor(renderOne(device(), scene, floor.camera, settings, &environment));
    };
    const double chosen = seen(false);
    EXPECT_NEAR(chosen / seen(true), 1, 0.005) << roughness;
    EXPECT_GT(chosen / radianceBelow(sky), 0.8) << roughness;  // the wall reflects about as much as it blocks
  }
}

// --- coats and transmission ------------------------------------------------------------------------------------------

// A white dielectric with coats or transmission.
scene::Material coated(float roughness, const std::function<void(shared::MaterialLayers&)>& edit) {
  scene::Scene scene;
  addMaterial(scene, vec3(1));
  scene::Material material = scene.materials[0];
  material.data.roughness = roughness;
  material.data.specular = 1;
  material.data.f0 = 0.04f;
  edit(material.data.layers);
  return material;
}
scene::Material glass(float roughness, float thickness) {
  return coated(roughness, [&](shared::MaterialLayers& l) { l.transmission = 1, l.thickness = thickness; });
}

// Names of materials with the materials.
using NamedMaterials = std::vector<std::pair<std::string, scene::Material>>;

// White furnace: copies of a mesh within [-1, 1]^3 side by side, tilted, in a uniform environment. Returns the radiance
// of each material by path tracing, as a mean over the `pixels` x `pixels` pixels at the center of 16 x 16.
std::vector<double> furnaceRadiances(vk::Device& device, const scene::Mesh& mesh, const NamedMaterials& kinds,
                                     uint32_t pixels, uint32_t samples) {
  scene::SceneBuilder builder("furnace");
  scene::Scene& scene = builder.scene;
  scene.meshes.push_back(mesh);
  const auto count = static_cast<uint32_t>(kinds.size());
  for (uint32_t i = 0; i < count; ++i) {
    scene.materials.push_back(kinds[i].second);
    scene.materials.back().data.id = i + 1;
    builder.addInstance(kinds[i].first, builder.kRoot, 0, i, glm::mat4(1));
    const glm::dmat4 turned = glm::rotate(glm::dmat4(1), 0.5, dvec3(1, 2, 0.5));
    scene.instances[i].toWorld = glm::translate(glm::dmat4(1), dvec3(2.0 * i + 1 - count, 0, 0)) * turned *
                                 glm::scale(glm::dmat4(1), dvec3(0.7));
  }
  FloorScene view(boxMesh(), glm::dmat4(1), sunFrom({0, 0, 1}));
  view.camera.yHalf = 1;
  Settings settings = settingsOf(16 * count, 16, {Aov::Color});
  settings.lighting = &findTechnique("reference");
  settings.samples = samples;
  const scene::Environment environment = constantEnvironment();
  const output::FrameOutput frame = renderOne(device, scene, view.camera, settings, &environment);
  const std::vector<float>& values = imageOf(frame, Aov::Color).values;
  const uint32_t first = 8 - pixels / 2;
  std::vector<double> radiances;
  for (uint32_t i = 0; i < count; ++i) {
    double sum = 0;
    for (uint32_t y = first; y < first + pixels; ++y)
      for (uint32_t x = 16 * i + first; x < 16 * i + first + pixels; ++x) {
        const float* pixel = &values[4 * (16 * count * y + x)];
        sum += (pixel[0] + pixel[1] + pixel[2]) / 3;
      }
    radiances.push_back(sum / (pixels * pixels));
  }
  return radiances;
}

TEST_F(RayLightTest, WhiteCoatsVanishInAFurnace) {
  const NamedMaterials kinds = {
      {"clearcoat", coated(0.5f, [](auto& l) { l.clearcoat = 1, l.clearcoatRoughness = 0.3f; })},
      {"anisotropy", coated(0.3f, [](auto& l) { l.anisotropy = 0.8f; })},
      {"diffuse transmission",
       coated(0.6f, [](auto& l) { l.diffuseTransmission = 0.5f, l.diffuseTransmissionColor = vec3(1); })},
      {"smooth thin glass", glass(0, 0)},
      {"rough thin glass", glass(0.5f, 0)},
      {"smooth volume", glass(0, 1)},
      {"rough volume", glass(0.3f, 1)},
      {"roughest volume", glass(1, 1)},
      {"half transmissive", coated(0.3f, [](auto& l) { l.transmission = 0.5f, l.thickness = 1; })}};
  // The means over 100 pixels have standard deviations of up to 0.2 %.
  const std::vector<double> radiances = furnaceRadiances(device(), boxMesh(), kinds, 10, 1024);
  for (size_t i = 0; i < kinds.size(); ++i) {
    // The albedos of stretched lobes and of the transmission lobe are approximations (docs/accuracy.md).
    const bool approximate = kinds[i].first == "anisotropy" || kinds[i].first == "rough thin glass";
    EXPECT_NEAR(radiances[i], 1, approximate ? 0.015 : 0.005) << kinds[i].first;
  }
}

scene::Material mixedVolume(float roughness, float transmission, float metallic = 0, float diffuseTransmission = 0) {
  scene::Material material = coated(roughness, [&](shared::MaterialLayers& l) {
    l.transmission = transmission, l.thickness = 1;
    l.diffuseTransmission = diffuseTransmission, l.diffuseTransmissionColor = vec3(1);
  });
  material.data.metallic = metallic;
  return material;
}

// White volumes that transmit in part and are metals in part. In a smooth sphere, each path keeps its angle to the
// surface until the diffuse part scatters it. The means have standard deviations of up to 0.5 %.
TEST_F(RayLightTest, MixedVolumesVanishInAFurnace) {
  const NamedMaterials kinds = {{"transmission 0.9, smooth", mixedVolume(0, 0.9f)},
                                {"transmission 0.5, smooth", mixedVolume(0, 0.5f)},
                                {"transmission 0.1, smooth", mixedVolume(0, 0.1f)},
                                {"transmission 0.5, roughness 0.1", mixedVolume(0.1f, 0.5f)},
                                {"diffuse transmission, smooth", mixedVolume(0, 0.5f, 0, 1)},
                                {"metallic 0.5, smooth", mixedVolume(0, 1, 0.5f)},
                                {"metallic 0.25, roughness 0.3", mixedVolume(0.3f, 1, 0.25f)},
                                {"all in part", mixedVolume(0.1f, 0.5f, 0.5f, 0.5f)}};
  const std::vector<double> boxes = furnaceRadiances(device(), boxMesh(), kinds, 10, 128);
  const std::vector<double> spheres = furnaceRadiances(device(), sphereMesh(1, 128), kinds, 8, 256);
  for (size_t i = 0; i < kinds.size(); ++i) {
    EXPECT_NEAR(boxes[i], 1, 0.015) << kinds[i].first;
    EXPECT_NEAR(spheres[i], 1, 0.015) << kinds[i].first;
  }
}

// A glass plate of thickness 0.5 over a floor that emits 1, or below one, seen head-on from between both. `edit` may
// change the scene and the settings.
float throughPlate(vk::Device& device, scene::Material material, double emitterHeight,
                   const std::function<void(FloorScene&, Settings&)>& edit = {}) {
  glm::dmat4 placed(1);
  placed[0].x = placed[1].y = 4;
  placed[2].z = 0.25;
  placed[3].z = 2;
  FloorScene plate(boxMesh(), placed, sunFrom({0, 0, 1}));
  scene::Scene& scene = plate.builder.scene;
  scene.lights.clear();
  scene.instances[0].material = addMaterial(scene, vec3(0), vec3(1));
  scene.instances[0].toWorld[3].z = emitterHeight;
  material.data.id = 3;
  scene.materials.push_back(std::move(material));
  scene.instances[1].material = 2;
  plate.camera.toWorld[3].z = 6;
  plate.camera.yHalf = 0.5;
  Settings settings = plate.settings();
  settings.width = settings.height = 16;
  settings.samples = 256;
  settings.lighting = &findTechnique("reference");
  if (edit) edit(plate, settings);
  return meanColor(renderOne(device, scene, plate.camera, settings));
}

// All internal reflections of a plate add up to 2R / (1 + R), and the rest passes.
TEST_F(RayLightTest, AGlassPlateReflectsTwiceTheFresnelTerm) {
  const double r = 0.04;
  EXPECT_NEAR(throughPlate(device(), glass(0, 1), 0), (1 - r) / (1 + r), 0.003);
  EXPECT_NEAR(throughPlate(device(), glass(0, 1), 12), 2 * r / (1 + r), 0.003);
}

// A surface of metalness m reflects m times the metal's F0, the base color b, and (1 - m) times the dielectric's. It
// refracts (1 - m) (1 - 0.04) b, and in both directions alike.
TEST_F(RayLightTest, AMetallicPlateReflectsByItsMetalness) {
  for (const double m : {0.25, 0.5, 0.75})
    for (const double b : {0.5, 1.0}) {
      scene::Material material = glass(0, 1);
      material.data.metallic = static_cast<float>(m);
      material.data.baseColor = glm::vec4(vec3(static_cast<float>(b)), 1);
      const double reflected = m * b + (1 - m) * 0.04, refracted = (1 - m) * 0.96 * b;
      const double between = 1 / (1 - reflected * reflected);  // sum over the reflections inside
      EXPECT_NEAR(throughPlate(device(), material, 0), refracted * refracted * between, 0.003) << m << ' ' << b;
      EXPECT_NEAR(throughPlate(device(), material, 12), reflected * (1 + refracted * refracted * between), 0.005)
          << m << ' ' << b;
    }
}

// With transmission t and a black diffuse part, surfaces reflect t times the Fresnel term inside, and all of it
// outside.
TEST_F(RayLightTest, APartlyTransmissivePlateRefractsItsTransmission) {
  const double r = 0.04, t = 0.5;
  scene::Material material = mixedVolume(0, static_cast<float>(t), 0, 1);
  material.data.layers.diffuseTransmissionColor = vec3(0);
  const double refracted = t * (1 - r), between = 1 / (1 - t * r * t * r);
  EXPECT_NEAR(throughPlate(device(), material, 0), refracted * refracted * between, 0.003);
  EXPECT_NEAR(throughPlate(device(), material, 12), r + refracted * refracted * t * r * between, 0.003);
}

// Light that crosses the plate once keeps the fraction a: (1 - R)^2 a / (1 - R^2 a^2) of it passes.
TEST_F(RayLightTest, AVolumeAbsorbsByItsDepth) {
  scene::Material material = glass(0, 1);
  material.data.layers.attenuationColor = vec3(0.25f);
  material.data.layers.attenuationDistance = 1;
  const double r = 0.04, a = std::pow(0.25, 0.5);
  EXPECT_NEAR(throughPlate(device(), material, 0), (1 - r) * (1 - r) * a / (1 - r * r * a * a), 0.003);
}

// A black pane with an alpha of 0.25 replaces that fraction of the light below it.
TEST_F(RayLightTest, BlendedSurfacesCoverByTheirAlpha) {
  scene::Material material = coated(1, [](auto&) {});
  material.data.baseColor = glm::vec4(0, 0, 0, 0.25f);
  material.data.specular = 0;
  material.data.flags |= shared::kMaterialBlended;
  EXPECT_NEAR(throughPlate(device(), material, 0), 0.75 * 0.75, 0.005);  // two sides of the box
}

// The eye's rays and those to the sun pass 24 black panes of two sides each.
TEST_F(RayLightTest, ManyBlendedSurfacesCoverByTheirAlpha) {
  scene::Material material = coated(1, [](auto&) {});
  material.data.baseColor = glm::vec4(0, 0, 0, 0.01f);
  material.data.specular = 0;
  material.data.flags |= shared::kMaterialBlended;
  const auto stack = [](FloorScene& floor, Settings& settings) {
    scene::Scene& scene = floor.builder.scene;
    const glm::dmat4 first = scene.instances[1].toWorld;
    for (uint32_t i = 1; i < 24; ++i)
      floor.builder.addInstance("pane " + std::to_string(i), floor.builder.kRoot, 1, 2, glm::mat4(1));
    for (uint32_t i = 1; i < 25; ++i) {
      scene.instances[i].toWorld = first;
      scene.instances[i].toWorld[2].z = 0.05;
      scene.instances[i].toWorld[3].z = 0.2 * i;
    }
    settings.samples = 64;  // of 256 pixels: a standard deviation of 0.004
  };
  const auto litStack = [&](FloorScene& floor, Settings& settings) {
    stack(floor, settings);
    floor.builder.scene.instances[0].material = 0;  // white
    floor.builder.scene.lights.push_back(sunFrom({0, 0, 1}));
  };
  const double passed = std::pow(0.99, 48);
  EXPECT_NEAR(throughPlate(device(), material, 0, stack), passed, 0.015);
  EXPECT_NEAR(throughPlate(device(), material, 0, litStack), passed * passed, 0.015);
}

// Between nested spheres, paths visit so much that lavapipe would end the loops of the shader, and lose the sample.
TEST_F(RayLightTest, PathsBetweenBlendedSurfacesLoseNoSamples) {
  scene::SceneBuilder builder{"spheres"};
  scene::Scene& scene = builder.scene;
  const uint32_t white = addMaterial(scene, vec3(1)), blended = addMaterial(scene, vec3(1));
  scene.materials[blended].data.baseColor.a = 0.3f;
  scene.materials[blended].data.flags |= shared::kMaterialBlended;
  scene.meshes = {squareMesh(), sphereMesh(1)};
  for (scene::Mesh& mesh : scene.meshes) scene::findBounds(mesh);
  builder.addInstance("wall", builder.kRoot, 0, white, glm::mat4(1));
  scene.instances[0].toWorld =
      glm::translate(glm::dmat4(1), dvec3(0, 0, -2)) * glm::scale(glm::dmat4(1), dvec3(4, 4, 1));
  for (uint32_t i = 0; i < 10; ++i) {
    builder.addInstance("sphere " + std::to_string(i), builder.kRoot, 1, blended, glm::mat4(1));
    scene.instances[i + 1].toWorld = glm::scale(glm::dmat4(1), dvec3(1 + 0.02 * i));
  }
  FloorScene view(boxMesh(), glm::dmat4(1), sunFrom({0, 0, 1}));
  view.camera.yHalf = 1.5;
  Settings settings = settingsOf(24, 24, {Aov::Color});
  settings.lighting = &findTechnique("reference");
  settings.samples = 4;
  const scene::Environment environment = constantEnvironment();
  const output::FrameOutput frame = renderOne(device(), scene, view.camera, settings, &environment);
  const std::vector<float>& values = imageOf(frame, Aov::Color).values;
  for (size_t i = 0; i < values.size(); i += 4) {
    EXPECT_EQ(values[i + 3], 1) << i / 4;
    EXPECT_GT(values[i], 0.1f) << i / 4;
  }
}

// The camera, 6 m above the floor, sees no pane before its near plane, and no floor behind its far plane.
TEST_F(RayLightTest, PathsStartWithinTheViewVolume) {
  scene::Material pane = coated(1, [](auto&) {});
  pane.data.baseColor = glm::vec4(0, 0, 0, 0.25f);
  pane.data.specular = 0;
  pane.data.flags |= shared::kMaterialBlended;
  for (const bool orthographic : {true, false}) {
    SCOPED_TRACE(orthographic);
    const auto seen = [&](float near, float far) {
      return throughPlate(device(), pane, 0, [&](FloorScene& plate, Settings&) {
        plate.camera.orthographic = orthographic;
        plate.camera.verticalFov = 0.1f;
        plate.camera.nearClip = near;
        plate.camera.farClip = far;
      });
    };
    EXPECT_NEAR(seen(0.5f, 100), 0.75 * 0.75, 0.005);
    EXPECT_NEAR(seen(4, 100), 0.75, 0.005);  // between the sides of the pane, which are at depths of 3.5 and 4 m
    EXPECT_NEAR(seen(5, 100), 1, 1e-3);
    EXPECT_TRUE(std::isnan(seen(0.5f, 5.5f)));  // no pixel is opaque
  }
}

// Surfaces inside a volume do not count as bounces, so one bounce finds all light of a small emitter behind rough
// glass.
TEST_F(RayLightTest, OneBounceFindsEmittersBehindRoughGlass) {
  for (const float roughness : {0.1f, 0.5f}) {
    const auto seen = [&](Indirect indirect) {
      return throughPlate(device(), glass(roughness, 1), 0, [&](FloorScene& plate, Settings& settings) {
        plate.builder.scene.instances[0].toWorld[0].x = plate.builder.scene.instances[0].toWorld[1].y = 0.25;
        settings.lighting = &findTechnique("clustered");
        settings.indirect = indirect;
      });
    };
    const float path = seen(Indirect::Path);
    EXPECT_GT(path, 0.01f);
    EXPECT_NEAR(seen(Indirect::OneBounce), path, 0.01 * path) << roughness;
  }
}

// A metal in an absorbing volume reflects an area light: light travels 2 m to the metal and 3 m to the eye's side.
TEST_F(RayLightTest, VolumesAbsorbTheLightOfAreaLights) {
  for (const float roughness : {0.05f, 0.6f}) {
    const auto seen = [&](float distance) {
      scene::Material material = glass(0, 1);
      material.data.f0 = 0;
      material.data.specular = 0;
      material.data.layers.attenuationColor = vec3(0.5f);
      material.data.layers.attenuationDistance = distance;
      return throughPlate(device(), material, 0, [&](FloorScene& plate, Settings&) {
        scene::Scene& scene = plate.builder.scene;
        scene.instances[1].toWorld[2].z = 2;  // from 1 m below the floor to 3 m above it
        scene.instances[1].toWorld[3].z = 1;
        scene.materials[1].data.emissive = vec3(0);
        scene.materials[1].data.baseColor = glm::vec4(1);
        scene.materials[1].data.metallic = 1;
        scene.materials[1].data.roughness = roughness;
        scene::Light light;
        light.type = shared::kLightDisk;
        light.position = {0, 0, 2};
        light.size = 0.4f;
        light.intensity = 10;
        scene.lights = {light};
      });
    };
    const float clear = seen(std::numeric_limits<float>::infinity());
    EXPECT_GT(clear, 0.01f);
    EXPECT_NEAR(seen(4) / clear, std::pow(0.5, 5.0 / 4), 0.01) << roughness;
  }
}

// Rays to lights pass smooth thin walls, by what these do not reflect: 1 - 0.04 for each of two, times their color. The
// floor is dark, so that hardly any light returns from it.
TEST_F(RayLightTest, LightPassesThinGlass) {
  scene::Material material = glass(0, 0);
  material.data.baseColor = glm::vec4(0.5f, 0.5f, 0.5f, 1);
  material.data.id = 3;
  glm::dmat4 placed(1);
  placed[0].x = placed[1].y = 4;
  placed[3].z = 2;
  FloorScene plate(boxMesh(), placed, sunFrom({0, 0, 1}));
  scene::Scene& scene = plate.builder.scene;
  scene.instances[0].material = addMaterial(scene, vec3(0.02f));
  scene.materials.push_back(std::move(material));
  scene.instances[1].material = 2;
  plate.camera.toWorld[3].z = 0.9;
  plate.camera.nearClip = 0.1f;
  plate.camera.yHalf = 0.5;
  Settings settings = plate.settings();
  settings.width = settings.height = 8;
  settings.samples = 64;
  settings.lighting = &findTechnique("reference");
  const float color = meanColor(renderOne(device(), scene, plate.camera, settings));
  EXPECT_NEAR(color / 0.02, 0.48 * 0.48, 0.01 * 0.48 * 0.48);
}

// A white metal of roughness 1 with the sun above it, seen from above. With alpha = 1, GGX is 1 / pi and Smith's
// visibility 1 / 4, so that pi lux have the radiance 1 / 4. A clearcoat of the same roughness reflects the light that
// it takes from the metal in the same lobe, and anisotropy does not stretch a lobe of alpha 1. With energy
// compensation, the metal would reflect more than twice as much.
TEST_F(RayLightTest, LightsOnCoatsFollowTheShading) {
  using Edit = std::function<void(shared::MaterialLayers&)>;
  const std::vector<std::pair<std::string, Edit>> kinds = {
      {"none", [](auto&) {}},
      {"clearcoat", [](auto& l) { l.clearcoat = 1, l.clearcoatRoughness = 1; }},
      {"faint clearcoat", [](auto& l) { l.clearcoat = 1e-3f, l.clearcoatRoughness = 1; }},
      {"anisotropy", [](auto& l) { l.anisotropy = 0.7f; }},
      {"faint sheen", [](auto& l) { l.sheenColor = vec3(1e-3f), l.sheenRoughness = 0.5f; }}};
  for (const auto& [name, edit] : kinds) {
    FloorScene floor(boxMesh(), glm::dmat4(1), sunFrom({0, 0, 1}));
    scene::Scene& scene = floor.builder.scene;
    scene.instances.pop_back();
    scene.materials[0] = coated(1, edit);
    scene.materials[0].data.metallic = 1;
    scene.materials[0].data.id = 1;
    Settings settings = floor.settings();
    settings.width = settings.height = 8;
    settings.samples = 1;
    settings.lighting = &findTechnique("reference");
    settings.shading = Shading::Ggx;
    EXPECT_NEAR(meanColor(renderOne(device(), scene, floor.camera, settings)), 0.25, 0.001) << name;
    settings.shading = Shading::GgxCompensated;
    EXPECT_GT(meanColor(renderOne(device(), scene, floor.camera, settings)), 0.4) << name;
  }
}

// The sun on a coated sphere, which does not light itself: paths shade it as the lighting techniques do.
TEST_F(RayLightTest, LightsOnCoatsAreThoseOfTheTechniques) {
  FloorScene floor(sphereMesh(1), glm::dmat4(1), sunFrom({0.3, 0.2, 1}));
  scene::Scene& scene = floor.builder.scene;
  scene.instances[0].toWorld[0].x = scene.instances[0].toWorld[1].y = 1e-3;
  scene.materials.push_back(coated(0.5f, [](auto& l) {
    l.clearcoat = 1, l.clearcoatRoughness = 0.2f;
    l.sheenColor = vec3(0.5f, 0.2f, 0.1f), l.sheenRoughness = 0.6f;
    l.anisotropy = 0.6f;
  }));
  scene.materials.back().data.id = 2;
  scene.instances[1].material = 1;
  floor.camera.yHalf = 0.9;
  Settings settings = floor.settings();
  settings.width = settings.height = 24;
  settings.shading = Shading::GgxCompensated;
  settings.shadows = ShadowFormat::None;
  const float expected = meanColor(renderOne(device(), scene, floor.camera, settings));
  settings.samples = 1;
  settings.lighting = &findTechnique("reference");
  EXPECT_NEAR(meanColor(renderOne(device(), scene, floor.camera, settings)) / expected, 1, 0.005);
}

// Root mean square difference of the first channel.
double differenceOf(const output::FrameOutput& a, const output::FrameOutput& b) {
  const std::vector<float>&x = imageOf(a, Aov::Color).values, &y = imageOf(b, Aov::Color).values;
  double sum = 0;
  for (size_t i = 0; i < x.size(); i += 4) sum += (x[i] - y[i]) * (x[i] - y[i]);
  return std::sqrt(4 * sum / static_cast<double>(x.size()));
}

// Views of one call have the pixels of calls of their own.
void expectSameAlone(vk::Device& device, const scene::Scene& scene, const std::vector<scene::Camera>& cameras,
                     const Settings& settings) {
  Renderer renderer(device, scene, nullptr);
  const std::vector<output::FrameOutput> together = renderer.render(cameras, settings);
  for (size_t i = 0; i < cameras.size(); ++i)
    EXPECT_EQ(imageOf(together[i], Aov::Color).values,
              imageOf(renderOne(device, scene, cameras[i], settings), Aov::Color).values);
}

// --- shared paths ----------------------------------------------------------------------------------------------------

// A lamp in a half-open box beside a metal sphere: light arrives by glossy, Lambertian and blocked connections.
struct LitCorner : FloorScene {
  explicit LitCorner(float lampRadius = 0) : FloorScene(sphereMesh(1), placedSphere(), lamp(lampRadius)) {
    scene::Scene& scene = builder.scene;
    material(0).data.baseColor = glm::vec4(0.8f, 0.6f, 0.4f, 1);
    scene.instances[1].material = addMaterial(scene, vec3(0.9f, 0.7f, 0.5f));
    material(1).data.metallic = 1;
    material(1).data.roughness = 0.4f;
    material(1).data.specular = 1;
    scene.meshes.push_back(boxMesh());
    builder.addInstance("wall", builder.kRoot, 2, addMaterial(scene, vec3(0.7f, 0.2f, 0.2f)), glm::mat4(1));
    scene.instances[2].toWorld = glm::dmat4(1);
    scene.instances[2].toWorld[0].x = 0.1;
    scene.instances[2].toWorld[3] = glm::dvec4(-1.2, 0, 0.5, 1);
    material(2).data.roughness = 0.5f;
    material(2).data.specular = 1;
    material(2).data.f0 = 0.04f;
    camera.yHalf = 1.5;
  }
  scene::Material& material(size_t index) { return builder.scene.materials[index]; }
  Settings settings(uint32_t width, uint32_t height, uint32_t samples) const {
    Settings s = FloorScene::settings();
    s.width = width, s.height = height;
    s.samples = samples;
    s.indirect = Indirect::Path;
    return s;
  }
  static glm::dmat4 placedSphere() {
    glm::dmat4 placed(0.4);
    placed[3] = glm::dvec4(0.5, 0, 0.5, 1);
    return placed;
  }
  static scene::Light lamp(float radius) {
    scene::Light light;
    light.type = shared::kLightPoint;
    light.intensity = 3;
    light.position = dvec3(-0.6, 0.2, 0.8);
    light.size = radius;
    return light;
  }
};

// The sphere is within eight radii of the second lamp, so all pixels of a workgroup share its highlights.
constexpr std::array kLampRadii{0.0f, 0.15f};

output::FrameOutput renderWith(vk::Device& device, const LitCorner& corner, uint32_t samples, bool reference) {
  Settings settings = corner.settings(24, 24, samples);
  if (reference) {
    settings.indirect = Indirect::None;
    settings.lighting = &findTechnique("reference");
  }
  return renderOne(device, corner.builder.scene, corner.camera, settings);
}

// Pixels of --indirect path share their paths, and those of --lighting reference do not. Both have the same mean, and
// shared paths have less noise.
TEST_F(RayLightTest, SharedPathsHaveLessNoiseAndTheSameMean) {
  for (const float radius : kLampRadii) {
    SCOPED_TRACE(radius);
    const LitCorner corner(radius);
    const output::FrameOutput truth = renderWith(device(), corner, 1024, true),
                              shared = renderWith(device(), corner, 32, false);
    EXPECT_NEAR(meanColor(shared) / meanColor(truth), 1, 0.01);
    EXPECT_LT(differenceOf(shared, truth), 0.7 * differenceOf(renderWith(device(), corner, 32, true), truth));
  }
}

// The walls of these kinds are translucent or have coats.
std::vector<std::pair<std::string, scene::Material>> wallsThatAreNotPlain() {
  scene::Material blended = coated(0.5f, [](auto&) {});
  blended.data.flags = shared::kMaterialBlended;
  blended.data.baseColor.a = 0.5f;
  return {{"clearcoat", coated(0.5f, [](auto& l) { l.clearcoat = 1, l.clearcoatRoughness = 0.3f; })},
          {"thin glass", glass(0, 0)},
          {"blended", blended}};
}

void setWall(LitCorner& corner, const scene::Material& material, double x) {
  scene::Scene& scene = corner.builder.scene;
  scene.materials.push_back(material);
  scene.materials.back().data.id = static_cast<uint32_t>(scene.materials.size());
  scene.instances[2].material = static_cast<uint32_t>(scene.materials.size() - 1);
  scene.instances[2].toWorld[3].x = x;
}

// Paths cross a wall in the middle of the picture, lit by an emissive sphere: the light of lights passes walls along
// paths only.
TEST_F(RayLightTest, SharedPathsCrossGlassAndFindCoats) {
  for (const auto& [kind, material] : wallsThatAreNotPlain()) {
    SCOPED_TRACE(kind);
    LitCorner corner;
    scene::Scene& scene = corner.builder.scene;
    scene.lights[0].intensity = 0;
    scene.instances[1].material = addMaterial(scene, vec3(0), vec3(2));
    setWall(corner, material, -0.4);
    EXPECT_NEAR(meanColor(renderWith(device(), corner, 16, false)) / meanColor(renderWith(device(), corner, 64, true)),
                1, 0.01);
  }
}

// A material that no path meets leaves every bit as it is, so plain surfaces share paths next to coats and glass.
TEST_F(RayLightTest, DistantCoatsAndGlassChangeNothing) {
  const auto render = [&](const scene::Material& material) {
    LitCorner corner;
    setWall(corner, material, -1e4);
    return imageOf(renderWith(device(), corner, 2, false), Aov::Color).values;
  };
  const std::vector<float> plain = render(coated(0.5f, [](auto&) {}));
  for (const auto& [kind, material] : wallsThatAreNotPlain()) EXPECT_EQ(render(material), plain) << kind;
}

// Groups of pixels that share paths do not reach beyond views, also at borders that cut workgroups.
TEST_F(RayLightTest, SharedPathsDoNotDependOnOtherViews) {
  for (const float radius : kLampRadii) {
    SCOPED_TRACE(radius);
    const LitCorner corner(radius);
    scene::Camera second = corner.camera;
    second.toWorld[3].x = 0.3;
    const Settings settings = corner.settings(37, 21, 2);
    expectSameAlone(device(), corner.builder.scene, {corner.camera, second}, settings);
  }
}

// --- the filter ------------------------------------------------------------------------------------------------------

// Where all light is the same, the filter changes nothing.
TEST_F(RayLightTest, TheFilterKeepsUniformLight) {
  const scene::Environment environment = constantEnvironment();
  for (const float metallic : {0.0f, 1.0f}) {
    scene::SceneBuilder builder("furnace");
    builder.scene.meshes.push_back(sphereMesh(1));
    builder.addInstance("sphere", builder.kRoot, 0, addMaterial(builder.scene, vec3(1)), glm::mat4(1));
    builder.scene.materials[0].data.metallic = metallic;
    builder.scene.materials[0].data.roughness = 0.5f;
    builder.scene.materials[0].data.specular = 1;
    builder.scene.materials[0].data.f0 = 0.04f;
    Settings settings = settingsOf(48, 32, {Aov::Color});
    settings.indirect = Indirect::Path;
    settings.indirectFilter = IndirectFilter::Spatial;
    settings.samples = 32;
    EXPECT_NEAR(meanColor(renderOne(device(), builder.scene, frontCamera(0.7f), settings, &environment)), 1, 0.01f);
  }
}

// The soft shadow of a square under a small lamp and a sky: few filtered samples are nearer to many samples than twice
// their number without a filter.
TEST_F(RayLightTest, TheFilterRemovesNoise) {
  FloorScene floor = floorBelowASquare(0.5, 1, vec3(4));
  floor.camera.yHalf = 1.5;
  floor.size = 48;
  const scene::Environment environment = constantEnvironment();
  Settings settings = floor.settings();
  settings.indirect = Indirect::OneBounce;
  const auto render = [&](uint32_t samples, IndirectFilter filter) {
    settings.samples = samples;
    settings.indirectFilter = filter;
    return renderOne(device(), floor.builder.scene, floor.camera, settings, &environment);
  };
  const output::FrameOutput truth = render(256, IndirectFilter::None);
  const double unfiltered = differenceOf(render(16, IndirectFilter::None), truth);
  const double filtered = differenceOf(render(8, IndirectFilter::Spatial), truth);
  // With a filter, a sample has one ray to the environment instead of four. The ratio is 0.52 on lavapipe, and 0.57 on
  // an H200.
  EXPECT_LT(filtered, 0.65 * unfiltered);
}

// The filter does not cross edges: beside a black wall and behind a step of depth, light stays where it is.
TEST_F(RayLightTest, TheFilterStopsAtEdges) {
  FloorScene floor = floorBelowASquare(1, 0.5, vec3(0));
  scene::Scene& scene = floor.builder.scene;
  scene.instances[0].material = addMaterial(scene, vec3(0), vec3(0));
  scene.instances[1].material = addMaterial(scene, vec3(1), vec3(0));  // above a black floor, in full light
  floor.camera.toWorld[3].z = 50;
  floor.camera.nearClip = 0.5f;
  floor.camera.yHalf = 2;
  const scene::Environment environment = constantEnvironment();
  Settings settings = floor.settings();
  settings.indirect = Indirect::OneBounce;
  settings.indirectFilter = IndirectFilter::Spatial;
  settings.samples = 8;
  const output::FrameOutput frame = renderOne(device(), scene, floor.camera, settings, &environment);
  for (uint32_t i = 0; i < floor.size * floor.size; ++i) {
    const bool above = vec3At(imageOf(frame, Aov::Position), i).z > 0.25f;
    EXPECT_NEAR(imageOf(frame, Aov::Color).values[4 * i], above ? 1 : 0, 0.01) << i;
  }
}

TEST_F(RayLightTest, FilteredViewsDoNotDependOnOthers) {
  const FloorScene floor = floorBelowASquare(0.5, 1, vec3(4));
  scene::Camera second = floor.camera;
  second.toWorld[3].x = 0.3;
  second.yHalf = 0.7;
  Settings settings = floor.settings();
  settings.width = 50, settings.height = 34;
  settings.indirect = Indirect::OneBounce;
  settings.indirectFilter = IndirectFilter::Spatial;
  settings.samples = 4;
  expectSameAlone(device(), floor.builder.scene, {floor.camera, second}, settings);
}

TEST_F(RayLightTest, RefusesWhatPathsCannotStartFrom) {
  const FloorScene floor(boxMesh(), glm::dmat4(1), sunFrom({0, 0, 1}));
  Settings settings = floor.settings();
  settings.indirect = Indirect::OneBounce;
  settings.lighting = &findTechnique("forward");
  EXPECT_THROW(renderOne(device(), floor.builder.scene, floor.camera, settings), Error);
  settings.lighting = &findTechnique("reference");
  settings.aa.samples = 4;
  EXPECT_THROW(renderOne(device(), floor.builder.scene, floor.camera, settings), Error);
}

}  // namespace
}  // namespace latelight::render::test
