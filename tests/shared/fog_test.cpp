// The closed form of fog's optical depth compared with numerical integration of its density.
#include "shared/fog.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/random.h"

namespace latelight {
namespace {

using shared::Fog;
using shared::vec3;

// Simpson's rule on the density along the ray.
double integrated(const Fog& fog, vec3 origin, vec3 direction, double distance) {
  constexpr int kSteps = 4000;
  const auto density = [&](double t) {
    const double z = double{origin.z} + double{direction.z} * t;
    return double{fog.density} * std::exp(-double{fog.falloff} * (z - double{fog.base}));
  };
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) sum += density(distance * i / kSteps) * (i == 0 || i == kSteps ? 1 : i % 2 ? 4 : 2);
  return sum * distance / kSteps / 3;
}

TEST(Fog, OpticalDepthIsTheIntegralOfItsDensity) {
  shared::Random random(7);
  double worst = 0;
  for (int i = 0; i < 400; ++i) {
    const Fog fog{.color = vec3(1),
                  .density = random.uniform(0.001f, 0.5f),
                  .falloff = i % 4 ? random.uniform(0.0f, 0.5f) : 0.0f,
                  .base = random.uniform(-5.0f, 5.0f)};
    const vec3 origin(0, 0, random.uniform(-10.0f, 30.0f));
    // From level rays, where the closed form is 0 / 0, to vertical ones.
    const float rise = i % 5 ? random.uniform(-1.0f, 1.0f) : random.uniform(-1e-4f, 1e-4f);
    const vec3 direction(std::sqrt(1 - rise * rise), 0, rise);
    const float distance = random.uniform(0.0f, 60.0f);
    const double expected = integrated(fog, origin, direction, distance);
    const double found = shared::fogOpticalDepth(fog, origin, direction, distance);
    if (expected > 1e-9) worst = std::max(worst, std::abs(found - expected) / expected);
  }
  EXPECT_LT(worst, 2e-5);
}

TEST(Fog, BeyondEverythingItIsTheLimitOfLongRays) {
  const Fog fog{.color = vec3(1), .density = 0.2f, .falloff = 0.3f, .base = 1};
  for (float rise : {0.05f, 0.3f, 1.0f}) {
    const vec3 direction(std::sqrt(1 - rise * rise), 0, rise);
    const double limit = shared::fogOpticalDepthToInfinity(fog, vec3(0, 0, 2), direction);
    EXPECT_NEAR(limit, integrated(fog, vec3(0, 0, 2), direction, 60 / (0.3 * double{rise})), 1e-4 * limit);
  }
  EXPECT_EQ(shared::fogTransmittance(shared::fogOpticalDepthToInfinity(fog, vec3(0), vec3(1, 0, 0))),
            std::exp(-shared::kFogMaxExponent));
  EXPECT_EQ(shared::fogOpticalDepthToInfinity({}, vec3(0), vec3(1, 0, 0)), 0.0f);
}

// All valid settings produce finite numbers.
TEST(Fog, ExtremesAreFinite) {
  for (float falloff : {0.0f, 1e-6f, 1.0f, 1e6f})
    for (float density : {1e-6f, 1e6f})
      for (float z : {-1e6f, 0.0f, 1e6f})
        for (float rise : {-1.0f, -1e-3f, 0.0f, 1e-3f, 1.0f})
          for (float distance : {0.0f, 1.0f, 1e6f}) {
            const Fog fog{.color = vec3(1), .density = density, .falloff = falloff, .base = 0};
            const vec3 direction(std::sqrt(1 - rise * rise), 0, rise);
            const float near =
                shared::fogTransmittance(shared::fogOpticalDepth(fog, vec3(0, 0, z), direction, distance));
            const float far =
                shared::fogTransmittance(shared::fogOpticalDepthToInfinity(fog, vec3(0, 0, z), direction));
            EXPECT_TRUE(near >= 0 && near <= 1) << falloff << ' ' << density << ' ' << z << ' ' << rise;
            EXPECT_TRUE(far >= 0 && far <= 1) << falloff << ' ' << density << ' ' << z << ' ' << rise;
          }
}

TEST(Fog, CoversWhatIsBehindIt) {
  const Fog fog{.color = vec3(0.2f, 0.4f, 0.8f), .density = 1, .falloff = 0, .base = 0};
  const shared::vec4 empty = shared::applyFog(fog, shared::vec4(0), 0.25f);
  EXPECT_EQ(empty, shared::vec4(0.15f, 0.3f, 0.6f, 0.75f));
  const shared::vec4 solid = shared::applyFog(fog, shared::vec4(2, 2, 2, 1), 0.25f);
  EXPECT_EQ(solid.w, 1.0f);
  EXPECT_FLOAT_EQ(solid.x, 0.65f);
}

}  // namespace
}  // namespace latelight
