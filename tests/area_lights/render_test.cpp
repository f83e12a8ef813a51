// Rendered light of area lights, against integrals of the renderer's BRDF over the surfaces of the lights.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "base/error.h"
#include "render/support.h"
#include "scene/edit.h"
#include "scene/scene_builder.h"
#include "shared/layers.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using glm::dvec3;
using glm::vec3;
using output::Aov;
using testing::HasSubstr;

// --- lights ----------------------------------------------------------------------------------------------------------

scene::Light areaLight(uint32_t type, dvec3 position, float radius) {
  scene::Light light;
  light.name = "area";
  light.type = type;
  light.position = position;
  light.size = radius;
  light.intensity = 3;
  return light;
}

// In axes of the renderer's world (Z up): above a floor, in its shapes' own sizes, and with scaled and sheared axes.
std::vector<scene::Light> allShapes() {
  scene::Light rect = areaLight(shared::kLightRect, {0, -0.5, 1.2}, 0);
  rect.width = 1.4f;
  rect.height = 0.5f;
  rect.color = {1, 0.5f, 0.25f};
  scene::Light disk = areaLight(shared::kLightDisk, {-1.5, 0.6, 0.8}, 0.4f);
  disk.axes = glm::mat3(vec3(0.8f, 0, 0.6f), vec3(0, 1, 0), vec3(-0.6f, 0, 0.8f));
  scene::Light sphere = areaLight(shared::kLightSphere, {1.4, 0.4, 0.6}, 0.25f);
  sphere.axes = glm::mat3(vec3(1.5f, 0, 0), vec3(0, 0.8f, 0.3f), vec3(0, 0, 1.2f));
  scene::Light tube = areaLight(shared::kLightTube, {0.2, 1.3, 0.5}, 0.08f);
  tube.length = 1.6f;
  tube.axes = glm::mat3(vec3(0.9f, 0.1f, 0.3f), vec3(0, 1, 0), vec3(-0.3f, 0, 0.9f));
  return {rect, disk, sphere, tube};
}

// Small pieces of the light's surface.
struct Element {
  dvec3 position, area;  // area: along the emitting side's normal
  bool twoSided = false;
};

std::vector<Element> elementsOf(const scene::Light& light) {
  constexpr int kSteps = 48;
  const glm::dmat3 axes(light.axes);
  std::vector<Element> elements;
  // Adds a parametrized part of the surface, in the light's space, where u and v are from 0 to 1.
  const auto add = [&](const std::function<dvec3(double, double)>& at, bool closed) {
    for (int i = 0; i < kSteps; ++i)
      for (int k = 0; k < kSteps; ++k) {
        constexpr double kStep = 1e-5;
        const double u = (i + 0.5) / kSteps, v = (k + 0.5) / kSteps;
        const dvec3 p = axes * at(u, v);
        const dvec3 du = (axes * at(u + kStep, v) - axes * at(u - kStep, v)) / (2 * kStep);
        const dvec3 dv = (axes * at(u, v + kStep) - axes * at(u, v - kStep)) / (2 * kStep);
        dvec3 area = glm::cross(du, dv) / double(kSteps * kSteps);
        if (glm::dot(area, closed ? p : -axes[2]) < 0) area = -area;
        elements.push_back({light.position + p, area, light.twoSided});
      }
  };
  const double radius = light.size;
  const auto disk = [radius](double x) {
    return [radius, x](double u, double v) {
      const double r = radius * std::sqrt(u);
      return x < 0 ? dvec3(r * std::cos(2 * M_PI * v), r * std::sin(2 * M_PI * v), 0)
                   : dvec3(x, r * std::cos(2 * M_PI * v), r * std::sin(2 * M_PI * v));
    };
  };
  if (light.type == shared::kLightRect)
    add([&](double u, double v) { return dvec3(light.width * (u - 0.5), light.height * (v - 0.5), 0); }, false);
  if (light.type == shared::kLightDisk) add(disk(-1), false);
  if (light.type == shared::kLightSphere)
    add(
        [&](double u, double v) {
          const double z = 2 * u - 1, r = std::sqrt(std::max(1 - z * z, 0.0));
          return radius * dvec3(r * std::cos(2 * M_PI * v), r * std::sin(2 * M_PI * v), z);
        },
        true);
  if (light.type == shared::kLightTube) {
    const double half = light.length / 2.0;
    add(
        [&](double u, double v) {
          return dvec3(half * (2 * u - 1), radius * std::cos(2 * M_PI * v), radius * std::sin(2 * M_PI * v));
        },
        true);
    for (const double end : {-1.0, 1.0})
      add(
          [&](double u, double v) {
            const dvec3 p = disk(half)(u, v);
            return dvec3(end * half, p.y, p.z);
          },
          true);
  }
  return elements;
}

struct Emitter {
  vec3 radiance;
  std::vector<Element> elements;
};
std::vector<Emitter> emittersOf(const std::vector<scene::Light>& lights) {
  std::vector<Emitter> emitters;
  for (const scene::Light& light : lights) emitters.push_back({light.color * light.intensity, elementsOf(light)});
  return emitters;
}

// What `shade` makes of the light of all elements that a position sees.
vec3 integral(const std::vector<Emitter>& emitters, dvec3 position,
              const std::function<vec3(const shared::LightSample&)>& shade) {
  dvec3 sum(0);
  for (const Emitter& emitter : emitters)
    for (const Element& element : emitter.elements) {
      const dvec3 offset = element.position - position;
      const double squared = glm::dot(offset, offset);
      const dvec3 toLight = offset / std::sqrt(squared);
      double facing = -glm::dot(element.area, toLight);
      if (element.twoSided) facing = std::abs(facing);
      if (facing <= 0) continue;
      sum += dvec3(shade({vec3(toLight), emitter.radiance, static_cast<float>(facing / squared)}));
    }
  return sum;
}

// --- the stage -------------------------------------------------------------------------------------------------------

// A floor in the plane z = 0 of the renderer's world, seen at an angle.
struct Stage {
  scene::SceneBuilder builder{"stage", false};
  scene::Camera camera;
  dvec3 eye{0, -5, 3};
  uint32_t width = 32, height = 24;

  explicit Stage(const scene::Material& material, std::vector<scene::Light> lights = allShapes()) {
    scene::Scene& scene = builder.scene;
    scene.materials.push_back(material);
    scene.meshes.push_back(squareMesh());
    scene::findBounds(scene.meshes[0]);
    builder.addInstance("floor", builder.kRoot, 0, 0, glm::mat4(1));
    scene.instances[0].toWorld = glm::dmat4(1);
    scene.instances[0].toWorld[0].x = scene.instances[0].toWorld[1].y = 4;
    scene.lights = std::move(lights);
    const dvec3 away = glm::normalize(-eye), right(1, 0, 0), up = glm::cross(right, away);
    camera.toWorld = glm::dmat4(glm::dvec4(right, 0), glm::dvec4(away, 0), glm::dvec4(up, 0), glm::dvec4(eye, 1));
    camera.verticalFov = 0.7f;
  }

  Settings settings() const {
    Settings s = inTheirRaster(settingsOf(width, height, {Aov::Color, Aov::Position}));
    s.axes = Axes::ZUp;
    s.layout = &findLayout("exact");
    return s;
  }
};

scene::Material lambertian() {
  scene::Material material = scene::plainMaterial("white", vec3(0.8f, 0.7f, 0.6f), 0, 1);
  material.data.specular = 0;
  return material;
}
scene::Material metal(float roughness) {
  return scene::plainMaterial("metal", vec3(1, 0.8f, 0.6f), 1, roughness);
}

shared::Surface surfaceOf(const scene::Material& material, dvec3 position) {
  const shared::Material& m = material.data;
  shared::Surface s = shared::emptySurface();
  s.position = vec3(position);
  s.baseColor = vec3(m.baseColor);
  s.metallic = m.metallic;
  s.roughness = m.roughness;
  s.f0 = glm::min(m.specularColor * m.f0, vec3(1)) * m.specular;
  s.f90 = m.specular;
  return s;
}

// The largest difference from the integral over the floor, as a fraction of the brightest value.
struct Difference {
  double worst = 0, mean = 0, brightest = 0;
};

using Shade = std::function<vec3(const shared::Surface&, vec3 toEye, const shared::LightSample&)>;
vec3 shadePlain(const shared::Surface& s, vec3 toEye, const shared::LightSample& light) {
  return shared::shadeLight(shared::surfaceBrdf(s, toEye, shared::kShadingGgx), light, shared::kShadingGgx);
}

Difference differenceOf(const output::FrameOutput& frame, const Stage& stage, const std::vector<scene::Light>& lights,
                        const Shade& shade = shadePlain) {
  const auto& color = imageOf(frame, Aov::Color).values;
  const std::vector<Emitter> emitters = emittersOf(lights);
  std::vector<double> differences;
  Difference result;
  for (size_t i = 0; i < color.size() / 4; i += 7) {
    if (color[4 * i + 3] == 0) continue;
    const dvec3 position(vec3At(imageOf(frame, Aov::Position), i));
    const shared::Surface s = surfaceOf(stage.builder.scene.materials[0], position);
    const vec3 toEye(glm::normalize(stage.eye - position));
    const vec3 expected =
        integral(emitters, position, [&](const shared::LightSample& l) { return shade(s, toEye, l); });
    for (int c = 0; c < 3; ++c) {
      differences.push_back(std::abs(color[4 * i + size_t(c)] - expected[c]));
      result.brightest = std::max(result.brightest, double{expected[c]});
    }
  }
  EXPECT_GT(differences.size(), 150u);
  for (const double d : differences) {
    result.worst = std::max(result.worst, d / result.brightest);
    result.mean += d / result.brightest / double(differences.size());
  }
  return result;
}

testing::AssertionResult isBlack(const std::vector<float>& colors) {
  for (size_t i = 0; i < colors.size(); ++i)
    if (i % 4 != 3 && colors[i] != 0) return testing::AssertionFailure() << colors[i] << " at " << i / 4;
  return testing::AssertionSuccess();
}

class AreaLightTest : public RenderTest {
 protected:
  static output::FrameOutput rendered(const Stage& stage, const Settings& settings) {
    return renderOne(device(), stage.builder.scene, stage.camera, settings);
  }
  static std::vector<float> colors(const Stage& stage, const Settings& settings) {
    return imageOf(rendered(stage, settings), Aov::Color).values;
  }
};

// --- without shadows -------------------------------------------------------------------------------------------------

TEST_F(AreaLightTest, LambertianLightIsTheIntegralInEveryTechnique) {
  const Stage stage(lambertian());
  for (const TechniqueInfo& technique : techniques()) {
    SCOPED_TRACE(technique.name);
    Settings settings = stage.settings();
    settings.lighting = &technique;
    if (technique.draws) settings.raster = Raster::Hardware;
    const Difference d = differenceOf(rendered(stage, settings), stage, allShapes());
    EXPECT_GT(d.brightest, 0.3);
    EXPECT_LT(d.worst, 3e-3);  // of which the half floats of the picture are 5e-4, and the ends of the tube most
  }
}

TEST_F(AreaLightTest, BothRastersAndEveryLayoutAgree) {
  const Stage stage(metal(0.4f));
  for (const Raster raster : {Raster::Hardware, Raster::Compute})
    for (const char* layout : {"exact", "visibility", "plain"}) {
      SCOPED_TRACE(layout);
      Settings settings = stage.settings();
      settings.layout = &findLayout(layout);
      settings.raster = raster;
      settings = inTheirRaster(settings);
      EXPECT_LT(differenceOf(rendered(stage, settings), stage, allShapes()).worst, 0.03);
    }
}

TEST_F(AreaLightTest, SpecularLightIsTheIntegralUpToTheFit) {
  for (const float roughness : {0.2f, 0.3f, 0.6f, 1.0f}) {
    const Stage stage(metal(roughness));
    const Difference d = differenceOf(rendered(stage, stage.settings()), stage, allShapes());
    fmt::print("roughness {}: mean {:.4f}, worst {:.4f}\n", roughness, d.mean, d.worst);
    EXPECT_LT(d.worst, 0.06) << roughness;
    EXPECT_LT(d.mean, 0.008) << roughness;
  }
}

TEST_F(AreaLightTest, DielectricsLoseTheLightOfTheirLobe) {
  const Stage stage(scene::plainMaterial("plastic", vec3(0.5f, 0.1f, 0.1f), 0, 0.35f));
  EXPECT_LT(differenceOf(rendered(stage, stage.settings()), stage, allShapes()).worst, 0.04);
}

TEST_F(AreaLightTest, CoatsReflectThem) {
  scene::Material material = scene::plainMaterial("coated", vec3(0.3f, 0.1f, 0.1f), 0, 0.8f);
  material.data.layers.clearcoat = 1;
  material.data.layers.clearcoatRoughness = 0.3f;
  const Stage stage(material);
  const Shade shade = [&](const shared::Surface& s, vec3 toEye, const shared::LightSample& light) {
    shared::SurfaceLayers layers = shared::emptyLayers();
    layers.clearcoat = 1;
    layers.clearcoatRoughness = 0.3f;
    const shared::LayeredBrdf b = shared::layeredBrdf(s, layers, toEye, shared::kShadingGgx, {});
    return shared::shadeLayeredLight(b, light, shared::kShadingGgx);
  };
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    Settings settings = stage.settings();
    settings.raster = raster;
    EXPECT_LT(differenceOf(rendered(stage, settings), stage, allShapes(), shade).worst, 0.03);
  }
}

TEST_F(AreaLightTest, BlendedSurfacesReceiveThem) {
  scene::Material material = lambertian();
  const std::vector<float> opaque = colors(Stage(material), Stage(material).settings());
  material.data.flags |= shared::kMaterialBlended;
  material.data.baseColor.a = 0.5f;
  const Stage stage(material);
  const std::vector<float> blended = colors(stage, stage.settings());
  for (size_t i = 0; i < opaque.size(); ++i)
    if (i % 4 != 3) {
      EXPECT_NEAR(blended[i], opaque[i] / 2, 2e-3f);
    }
}

TEST_F(AreaLightTest, TwoSidedLightsShineBothWays) {
  scene::Light rect = areaLight(shared::kLightRect, {0, 0, 1}, 0);
  rect.axes = glm::mat3(vec3(1, 0, 0), vec3(0, -1, 0), vec3(0, 0, -1));  // emits up
  const Stage dark(lambertian(), {rect});
  EXPECT_TRUE(isBlack(colors(dark, dark.settings())));
  rect.twoSided = true;
  const Stage lit(lambertian(), {rect});
  EXPECT_LT(differenceOf(rendered(lit, lit.settings()), lit, {rect}).worst, 2e-3);
}

// Mirrored axes have the same light, and -Z stays the emitting side.
TEST_F(AreaLightTest, MirroredLightsEmitToTheSameSide) {
  std::vector<scene::Light> lights = allShapes();
  for (scene::Light& light : lights) light.axes[0] = -light.axes[0];
  const Stage mirrored(lambertian(), lights), stage(lambertian());
  const std::vector<float> a = colors(mirrored, mirrored.settings()), b = colors(stage, stage.settings());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-3f);
}

TEST_F(AreaLightTest, ShapesWithoutExtentEmitNothing) {
  std::vector<scene::Light> lights = allShapes();
  for (scene::Light& light : lights) light.axes[1] = vec3(0);
  const Stage stage(lambertian(), lights);
  EXPECT_TRUE(isBlack(colors(stage, stage.settings())));
}

TEST_F(AreaLightTest, InsideAShapeThereIsNoLightOfIt) {
  // The floor's middle is inside.
  const Stage stage(lambertian(), {areaLight(shared::kLightSphere, {0, 0, 0}, 1.0f)});
  const output::FrameOutput frame = rendered(stage, stage.settings());
  size_t inside = 0;
  for (size_t i = 0; i < size_t{stage.width} * stage.height; ++i) {
    if (imageOf(frame, Aov::Color).values[4 * i + 3] == 0) continue;
    const double distance = glm::length(vec3At(imageOf(frame, Aov::Position), i));
    const float value = imageOf(frame, Aov::Color).values[4 * i];
    ASSERT_TRUE(std::isfinite(value));
    if (distance < 0.99) {
      EXPECT_EQ(value, 0);
    }
    inside += distance < 0.99;
    if (distance > 1.05 && distance < 2) {
      EXPECT_GT(value, 0.01f);
    }
  }
  EXPECT_GT(inside, 20u);
}

// --- edits, worlds, limits -------------------------------------------------------------------------------------------

TEST_F(AreaLightTest, FollowEdits) {
  Stage stage(lambertian(), {});
  Renderer renderer(device(), stage.builder.scene, nullptr);
  const auto image = [&] {
    return imageOf(renderer.render({&stage.camera, 1}, stage.settings()).front(), Aov::Color).values;
  };
  const auto rebuilt = [&] { return imageOf(rendered(stage, stage.settings()), Aov::Color).values; };
  const std::vector<float> none = image();
  const uint32_t index = scene::addLight(stage.builder.scene, allShapes()[0]);
  const std::vector<float> one = image();
  EXPECT_NE(one, none);
  EXPECT_EQ(one, rebuilt());
  scene::Light changed = allShapes()[1];
  changed.intensity = 7;
  scene::setLight(stage.builder.scene, index, changed);
  EXPECT_EQ(image(), rebuilt());
  scene::removeLight(stage.builder.scene, index);
  EXPECT_EQ(image(), none);
}

TEST_F(AreaLightTest, HaveValuesPerWorld) {
  const Stage stage(lambertian());
  WorldStates worlds;
  worlds.count = 2;
  worlds.lights = {0, 2};
  for (const float intensity : {1.0f, 4.0f})
    for (const uint32_t light : worlds.lights) {
      scene::Light value = stage.builder.scene.lights[light];
      value.intensity = intensity;
      value.position.z += intensity / 10;
      worlds.lightValues.push_back(value);
    }
  Settings settings = stage.settings();
  settings.raster = Raster::Compute;
  Renderer renderer(device(), stage.builder.scene, nullptr);
  for (uint32_t world = 0; world < 2; ++world) {
    std::vector<scene::Light> lights = allShapes();
    for (size_t i = 0; i < 2; ++i) lights[worlds.lights[i]] = worlds.lightValues[2 * world + i];
    const Stage alone(lambertian(), lights);
    scene::Camera camera = stage.camera;
    camera.world = world;
    const output::FrameOutput frame = renderer.render({&camera, 1}, settings, {.worlds = worlds}).front();
    EXPECT_EQ(imageOf(frame, Aov::Color).values, colors(alone, settings));
  }
}

TEST_F(AreaLightTest, AreBoundedInNumber) {
  const Stage stage(lambertian(), std::vector<scene::Light>(shared::kMaxAreaLights + 1, allShapes()[0]));
  try {
    rendered(stage, stage.settings());
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("at most 64 area lights are supported, but the scene has 65"));
  }
}

// --- by rays ---------------------------------------------------------------------------------------------------------

// Without anything in the way, rays change nothing but rounding.
TEST_F(AreaLightTest, UnblockedRaysFindTheLightWithoutShadows) {
  const Stage stage(metal(0.3f));
  Settings settings = stage.settings();
  const std::vector<float> without = colors(stage, settings);
  settings.shadows = ShadowFormat::Rays;
  settings.samples = 4;
  const std::vector<float> with = colors(stage, settings);
  for (size_t i = 0; i < with.size(); ++i) EXPECT_NEAR(with[i], without[i], 4e-3f * (0.1f + without[i])) << i;
}

// Many lights at one place are one light with the sum of their luminances, although some devices round half floats
// down.
TEST_F(AreaLightTest, TheLightOfManyLightsIsTheirSum) {
  const std::vector<scene::Light> one = {areaLight(shared::kLightDisk, {0, 0, 1}, 0.5f)};
  std::vector<scene::Light> many(shared::kMaxAreaLights, one[0]);
  for (scene::Light& light : many) light.intensity /= shared::kMaxAreaLights;
  const Stage stage(lambertian(), many);
  Settings settings = stage.settings();
  settings.shadows = ShadowFormat::Rays;
  settings.samples = 2;
  EXPECT_LT(differenceOf(rendered(stage, settings), stage, one).worst, 2e-3);
}

// A wall hides the part of the light whose elements it blocks.
TEST_F(AreaLightTest, PenumbraeAreThoseOfTheVisiblePart) {
  for (const scene::Light& light : allShapes()) {
    Stage stage(lambertian(), {light});
    scene::Scene& scene = stage.builder.scene;
    stage.builder.addInstance("wall", scene::SceneBuilder::kRoot, 0, 0, glm::mat4(1));
    // The square z = 0.3, x from -0.5 to 0.7, at any y.
    scene.instances[1].toWorld = glm::dmat4(1);
    scene.instances[1].toWorld[0].x = 0.6;
    scene.instances[1].toWorld[1].y = 4;
    scene.instances[1].toWorld[3] = glm::dvec4(0.1, 0, 0.3, 1);
    Settings settings = stage.settings();
    settings.shadows = ShadowFormat::Rays;
    settings.samples = 200;
    const output::FrameOutput frame = rendered(stage, settings);
    const std::vector<Element> elements = elementsOf(light);
    double worst = 0, mean = 0, brightest = 0;
    int count = 0, shadowed = 0;
    for (size_t i = 0; i < size_t{stage.width} * stage.height; i += 5) {
      const dvec3 p(vec3At(imageOf(frame, Aov::Position), i));
      if (imageOf(frame, Aov::Color).values[4 * i + 3] == 0 || p.z > 0.1) continue;
      double lit = 0, all = 0;
      for (const Element& e : elements) {
        const dvec3 offset = e.position - p;
        const double facing = -glm::dot(e.area, offset);
        if (facing <= 0 || offset.z <= 0) continue;
        const double share = facing * offset.z / std::pow(glm::dot(offset, offset), 2) / M_PI;
        const dvec3 at = p + offset * (0.3 / offset.z);
        all += share;
        lit += offset.z > 0.3 && std::abs(at.x - 0.1) < 0.6 && std::abs(at.y) < 4 ? 0 : share;
      }
      const double scale = 0.8 * light.color.x * light.intensity;
      const double error = std::abs(imageOf(frame, Aov::Color).values[4 * i] - scale * lit);
      brightest = std::max(brightest, scale * all);
      worst = std::max(worst, error);
      mean += error;
      ++count;
      shadowed += lit < 0.9 * all;
    }
    EXPECT_GT(shadowed, 10) << light.type;
    EXPECT_LT(mean / count, 0.006 * brightest) << light.type;
    EXPECT_LT(worst, 0.08 * brightest) << light.type;
  }
}

TEST_F(AreaLightTest, OnlyLightsThatCastShadowsDo) {
  Stage stage(lambertian(), {allShapes()[0]});
  scene::Scene& scene = stage.builder.scene;
  stage.builder.addInstance("roof", scene::SceneBuilder::kRoot, 0, 0, glm::mat4(1));
  scene.instances[1].toWorld = glm::dmat4(1);
  scene.instances[1].toWorld[3].z = 0.6;
  Settings settings = stage.settings();
  const auto image = [&] { return colors(stage, settings); };
  const std::vector<float> without = image();
  settings.shadows = ShadowFormat::Rays;
  const std::vector<float> with = image();
  EXPECT_NE(with, without);
  settings.shadowLights = {.automatic = false, .most = 0, .names = {}};
  EXPECT_EQ(image(), without);
  settings.shadowLights = {};
  scene.lights[0].castShadow = false;
  EXPECT_EQ(image(), without);
  settings.shadowLights = {.automatic = false, .most = 1, .names = {"no such light"}};
  EXPECT_THROW(image(), Error);
}

// The reference samples the same light, and finds it with rays of the surface's lobe.
TEST_F(AreaLightTest, TheReferenceConvergesToTheIntegral) {
  for (const float roughness : {0.15f, 1.0f}) {
    const Stage stage(metal(roughness));
    Settings settings = stage.settings();
    settings.lighting = &findTechnique("reference");
    settings.samples = 256;
    const Difference d = differenceOf(rendered(stage, settings), stage, allShapes());
    fmt::print("roughness {}: mean {:.4f}, worst {:.4f}\n", roughness, d.mean, d.worst);
    EXPECT_LT(d.mean, 0.01) << roughness;
    EXPECT_LT(d.worst, 0.12) << roughness;
  }
}

// Light of paths is added to a technique's own, in which area lights have no part.
TEST_F(AreaLightTest, IndirectLightIncludesThemOnce) {
  const Stage stage(lambertian());
  Settings settings = stage.settings();
  const std::vector<float> direct = colors(stage, settings);
  settings.indirect = Indirect::OneBounce;
  settings.samples = 64;
  const std::vector<float> indirect = colors(stage, settings);
  double a = 0, b = 0;
  for (size_t i = 0; i < direct.size(); ++i)
    if (i % 4 != 3) a += direct[i], b += indirect[i];
  EXPECT_NEAR(b / a, 1, 0.01);  // the floor has nothing to exchange light with
}

}  // namespace
}  // namespace latelight::render::test
