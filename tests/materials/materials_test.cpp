// Compares the renderer's pictures of layered materials with reference pictures from the formulas, for punctual lights
// and by integration over an environment. With LATELIGHT_TEST_PICTURES=FOLDER, the test writes the pictures to that
// folder, and tests/materials/flip compares them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/parallel.h"
#include "long_tests.h"
#include "materials/grids.h"
#include "materials/integral.h"
#include "output/png.h"
#include "render/host_environment.h"
#include "render/support.h"
#include "scene/gltf_builder.h"

namespace latelight::materials {
namespace {

using glm::dvec3;
using render::test::HostEnvironment;
using shared::vec3;

constexpr uint32_t kSamples = 4096, kUsualSamples = 1024;

// The radiance of each pixel; 0 next to the spheres and at their rims.
using Radiance = std::vector<dvec3>;

template <typename F>
Radiance forEachPoint(const Grid& grid, F radianceAt) {
  Radiance picture(size_t{kWidth} * kHeight);
  parallelFor(picture.size(), 8, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Point p;
      p.toEye = kToEye;
      p.pixel = uint32_t(i);
      if (pointAt(grid, uint32_t(i % kWidth), uint32_t(i / kWidth), p.surface, p.layers)) picture[i] = radianceAt(p);
    }
  });
  return picture;
}

shared::LayerTables tablesAt(const Point& p, const HostEnvironment& environment) {
  const shared::LayerTables places = shared::layerTableCoordinates(p.surface, p.layers, p.toEye);
  const auto table = [&](shared::vec2 place) { return environment.splitSum(place.x, place.y); };
  return {table(places.base), table(places.coat), table(places.behind)};
}

// The lookups that shading uses instead of the integral (render/layered).
vec3 stretchedLobe(shared::LayeredBrdf& b, const HostEnvironment& environment) {
  const shared::FilmCurve film = shared::filmCurve(b);
  shared::StretchedSum sum = shared::emptySum();
  for (uint32_t i = 0; i < shared::kStretchedSamples; ++i) {
    const shared::LobeSample r = shared::baseSample(b, i);
    shared::addSample(sum, b, film, r, environment.radiance(r.toLight, shared::levelOfShare(r.solidAngle)));
  }
  return shared::meanOfSum(b, sum);
}

vec3 sheenLobe(const shared::LayeredBrdf& b, const HostEnvironment& environment) {
  const vec3 along = shared::alongEye(b.base.normal, b.base.toEye);
  vec3 sum(0.0f);
  float weights = 0.0f;
  for (uint32_t i = 0; i < shared::kSheenSamples; ++i) {
    const shared::SheenSample r =
        shared::sheenSample(b.base.normal, along, b.base.toEye, b.base.nv, b.layers.sheenRoughness, i);
    sum += environment.radiance(r.toLight, shared::levelOfShare(shared::kSheenSolidAngle)) * r.weight;
    weights += r.weight;
  }
  return sum / std::max(weights, 1e-20f);
}

dvec3 byLookups(const Point& p, const HostEnvironment& environment) {
  shared::LayeredBrdf b =
      shared::layeredBrdf(p.surface, p.layers, p.toEye, shared::kShadingGgx, tablesAt(p, environment));
  const auto roundLobe = [&](vec3 normal, float roughness) {
    return environment.lobe(normal, roughness, p.toEye, environment.around(normal));
  };
  shared::LayerLight light;
  light.front = environment.around(p.surface.normal);
  light.back = environment.around(p.surface.normal * -1.0f);
  light.sheen = sheenLobe(b, environment);
  light.base =
      p.layers.anisotropy > 0.0f ? stretchedLobe(b, environment) : roundLobe(p.surface.normal, p.surface.roughness);
  light.coat = roundLobe(p.layers.clearcoatNormal, p.layers.clearcoatRoughness);
  return dvec3(shared::shadeLayeredEnvironment(b, light));
}

shared::LightSample sampleAt(const scene::Light& light, vec3 position) {
  if (light.type == shared::kLightDirectional) return {light.direction * -1.0f, light.color * light.intensity, 1.0f};
  const vec3 offset = vec3(light.position) - position;
  return {glm::normalize(offset), light.color * light.intensity, 1.0f / glm::dot(offset, offset)};
}

dvec3 byLights(const Point& p) {
  const shared::LayerTables unused{};  // without energy compensation
  const shared::LayeredBrdf b = shared::layeredBrdf(p.surface, p.layers, p.toEye, shared::kShadingGgx, unused);
  vec3 sum(0.0f);
  for (const scene::Light& light : lights())
    sum += shared::shadeLayeredLight(b, sampleAt(light, p.surface.position), shared::kShadingGgx);
  return dvec3(sum);
}

void keep(const Radiance& radiance, const std::string& name) {
  const char* folder = std::getenv("LATELIGHT_TEST_PICTURES");
  if (!folder) return;
  output::Picture picture{kWidth, kHeight, {}};
  for (const dvec3& p : radiance) {
    for (int c = 0; c < 3; ++c) picture.rgba.push_back(uint8_t(std::lround(study::srgbLevel(p[c]))));
    picture.rgba.push_back(255);
  }
  std::string file = name + ".png";
  std::replace(file.begin(), file.end(), ' ', '-');
  const std::vector<std::byte> png = output::encodePng(picture);
  std::ofstream(std::filesystem::path(folder) / file, std::ios::binary)
      .write(reinterpret_cast<const char*>(png.data()), std::streamsize(png.size()));
}

// The mean and maximum difference over the pixels of spheres, in levels of 255 of the sRGB picture.
struct Apart {
  double mean = 0.0, worst = 0.0;
};
Apart apart(const Radiance& a, const Radiance& b) {
  Apart result;
  size_t lit = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] == dvec3(0.0) && b[i] == dvec3(0.0)) continue;
    for (int c = 0; c < 3; ++c, ++lit) {
      const double here = std::abs(study::srgbLevel(a[i][c]) - study::srgbLevel(b[i][c]));
      result.mean += here;
      result.worst = std::max(result.worst, here);
    }
  }
  EXPECT_GT(lit, a.size());  // most of the picture
  result.mean /= double(std::max(lit, size_t{1}));
  return result;
}

study::EnvironmentTruth truthOf(const scene::Environment& environment) {
  return study::EnvironmentTruth(scene::toFloats(environment.radiance));
}

const scene::Environment& studio() {
  static const scene::Environment once = scene::loadEnvironment("studio");
  return once;
}

class Materials : public render::test::RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    // test_layers compares both rasters.
    if (render::test::testRaster() == render::Raster::Compute) LATELIGHT_SKIP_UNLESS_ALL();
  }
  // Those pixels of the renderer's picture that `reference` has.
  static Radiance rendered(const Grid& grid, bool lit, const Radiance& reference) {
    scene::Scene scene = scene::test::GltfBuilder::loadBytes(glb(grid), "grid.glb");
    if (lit) scene.lights = lights();
    const render::Settings settings = render::test::settingsOf(kWidth, kHeight, {output::Aov::Color});
    const output::FrameOutput frame =
        render::test::renderOne(device(), scene, scene.cameras.front(), settings, lit ? nullptr : &studio());
    const output::AovImage& color = render::test::imageOf(frame, output::Aov::Color);
    Radiance picture(reference.size());
    for (size_t i = 0; i < picture.size(); ++i)
      if (reference[i] != dvec3(0.0))
        picture[i] = dvec3(color.values[4 * i], color.values[4 * i + 1], color.values[4 * i + 2]);
    return picture;
  }
};

TEST_F(Materials, LightsShadeByTheFormulas) {
  for (const Grid& grid : grids()) {
    const Radiance formulas = forEachPoint(grid, byLights), picture = rendered(grid, true, formulas);
    keep(picture, grid.name + ".lights");
    keep(formulas, grid.name + ".lights.reference");
    const Apart a = apart(picture, formulas);
    fmt::print("{}: {:.2f} levels in the mean, {:.1f} at worst\n", grid.name, a.mean, a.worst);
    EXPECT_LE(a.mean, 0.5) << grid.name;
  }
}

TEST_F(Materials, EnvironmentsShadeByTheLookups) {
  const HostEnvironment lookups(studio());
  for (const Grid& grid : grids()) {
    if (!grid.environment) continue;
    const Radiance formulas = forEachPoint(grid, [&](const Point& p) { return byLookups(p, lookups); });
    const Radiance picture = rendered(grid, false, formulas);
    keep(picture, grid.name + ".environment");
    const Apart a = apart(picture, formulas);
    fmt::print("{}: {:.2f} levels in the mean, {:.1f} at worst\n", grid.name, a.mean, a.worst);
    EXPECT_LE(a.mean, 0.5) << grid.name;
  }
}

// The lookup of a level uses directions whose shares add up to its lobe.
TEST(MaterialLookups, SharesFindTheLevelOfTheirWidth) {
  for (size_t level = 1; level < scene::kSpecularRoughness.size(); ++level) {
    const double alpha = std::pow(scene::kSpecularRoughness[level], 2.0);
    EXPECT_EQ(shared::levelOfShare(float(4.0 * M_PI * alpha * alpha / 0.3)), float(level));
  }
  EXPECT_EQ(shared::levelOfShare(0.0f), 0.0f);
  EXPECT_EQ(shared::levelOfShare(INFINITY), 5.0f);
}

// The lookups on the host. By the test above, they produce the renderer's pictures.
TEST(MaterialLookups, AreNearTheIntegral) {
  const HostEnvironment lookups(studio());
  const study::EnvironmentTruth truth = truthOf(studio());
  const uint32_t samples = latelight::test::rounds(kSamples, kUsualSamples);
  for (const Grid& grid : grids()) {
    if (!grid.environment) continue;
    const Radiance quick = forEachPoint(grid, [&](const Point& p) { return byLookups(p, lookups); });
    const Radiance integral =
        forEachPoint(grid, [&](const Point& p) { return integrate(p, tablesAt(p, lookups), truth, samples); });
    keep(integral, grid.name + ".environment.reference");
    const Apart a = apart(quick, integral);
    fmt::print("{}: {:.2f} levels in the mean, {:.1f} at worst\n", grid.name, a.mean, a.worst);
    EXPECT_LE(a.mean, 3.3) << grid.name;
  }
}

}  // namespace
}  // namespace latelight::materials
