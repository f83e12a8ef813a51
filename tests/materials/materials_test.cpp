// Pictures of layered materials under an environment: by the lookups that shading makes instead of the integral, and by
// the integral. With LATELIGHT_TEST_PICTURES=FOLDER both are left there, and tests/materials/flip judges them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/parallel.h"
#include "materials/grids.h"
#include "materials/integral.h"
#include "output/png.h"
#include "render/host_environment.h"

namespace latelight::materials {
namespace {

using glm::dvec3;
using render::test::HostEnvironment;
using shared::vec3;

constexpr uint32_t kSamples = 4096;

struct Radiance {
  std::vector<dvec3> pixels = std::vector<dvec3>(size_t{kWidth} * kHeight);
};

template <typename F>
Radiance forEachPoint(const Grid& grid, F radianceAt) {
  Radiance picture;
  parallelFor(picture.pixels.size(), 8, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Point p;
      p.toEye = kToEye;
      if (pointAt(grid, uint32_t(i % kWidth), uint32_t(i / kWidth), p.surface, p.layers))
        picture.pixels[i] = radianceAt(p);
    }
  });
  return picture;
}

// What the shaders look up (render/layered).
vec3 byLookups(const Point& p, const HostEnvironment& environment) {
  const shared::LayerTables places = shared::layerTablePlaces(p.surface, p.layers, p.toEye);
  const auto table = [&](shared::vec2 place) { return environment.splitSum(place.x, place.y); };
  const shared::LayeredBrdf b = shared::layeredBrdf(p.surface, p.layers, p.toEye, shared::kShadingGgx,
                                                    {table(places.base), table(places.coat), table(places.behind)});
  const auto partLight = [&](const shared::LobePart& part) {
    return environment.lobe(part.normal, part.roughness, p.toEye, environment.around(part.normal));
  };
  const auto mean = [&](uint32_t count, auto partOf) {
    vec3 sum(0.0f);
    float weights = 0.0f;
    for (uint32_t i = 0; i < count; ++i) {
      const shared::LobePart part = partOf(i);
      sum += partLight(part) * part.weight;
      weights += part.weight;
    }
    return sum / std::max(weights, 1e-6f);
  };
  shared::LayerLight light;
  light.front = environment.around(p.surface.normal);
  light.back = environment.around(p.surface.normal * -1.0f);
  light.coat = partLight(shared::coatPart(b));
  light.base = mean(shared::baseParts(b), [&](uint32_t i) { return shared::basePart(b, i); });
  light.sheen = environment.around(shared::sheenDirection(b));
  return shared::shadeLayeredEnvironment(b, light);
}

double level(double linear) {
  return study::srgbLevel(linear);
}

void keep(const Radiance& radiance, const std::string& name) {
  const char* folder = std::getenv("LATELIGHT_TEST_PICTURES");
  if (!folder) return;
  output::Picture picture{kWidth, kHeight, {}};
  for (const dvec3& p : radiance.pixels) {
    for (int c = 0; c < 3; ++c) picture.rgba.push_back(uint8_t(std::lround(level(p[c]))));
    picture.rgba.push_back(255);
  }
  const std::vector<std::byte> png = output::encodePng(picture);
  std::ofstream(std::filesystem::path(folder) / (name + ".png"), std::ios::binary)
      .write(reinterpret_cast<const char*>(png.data()), std::streamsize(png.size()));
}

// Mean and worst difference over the spheres' pixels, in levels of 255.
struct Apart {
  double mean = 0.0, worst = 0.0;
};
Apart apart(const Radiance& a, const Radiance& b) {
  Apart result;
  size_t lit = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    if (a.pixels[i] == dvec3(0.0) && b.pixels[i] == dvec3(0.0)) continue;
    for (int c = 0; c < 3; ++c, ++lit) {
      const double here = std::abs(level(a.pixels[i][c]) - level(b.pixels[i][c]));
      result.mean += here;
      result.worst = std::max(result.worst, here);
    }
  }
  result.mean /= double(std::max(lit, size_t{1}));
  return result;
}

std::string fileName(const Grid& grid) {
  std::string name = grid.name;
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

study::EnvironmentTruth truthOf(const scene::Environment& environment) {
  scene::FloatImage picture(environment.radiance.width, environment.radiance.height);
  for (size_t i = 0; i < environment.radiance.pixels.size(); ++i)
    picture.pixels[i] = scene::floatFromHalf(environment.radiance.pixels[i]);
  return study::EnvironmentTruth(std::move(picture));
}

TEST(Materials, EnvironmentLookupsAreNearTheIntegral) {
  const scene::Environment studio = scene::loadEnvironment("studio");
  const HostEnvironment lookups(studio);
  const study::EnvironmentTruth truth = truthOf(studio);
  for (const Grid& grid : grids()) {
    if (!grid.environment) continue;
    const Radiance quick = forEachPoint(grid, [&](const Point& p) { return dvec3(byLookups(p, lookups)); });
    if (getenv("QUICK")) { keep(quick, fileName(grid) + ".environment"); continue; }
    const Radiance integral = forEachPoint(grid, [&](const Point& p) { return integrate(p, truth, kSamples); });
    keep(quick, fileName(grid) + ".environment");
    keep(integral, fileName(grid) + ".environment.integral");
    const Apart a = apart(quick, integral);
    EXPECT_LE(a.mean, 5.0) << grid.name;
    fmt::print("{}: {:.2f} levels in the mean, {:.1f} at worst\n", grid.name, a.mean, a.worst);
  }
}

}  // namespace
}  // namespace latelight::materials
