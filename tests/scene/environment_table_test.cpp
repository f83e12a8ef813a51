// The split-sum table compared with a quadrature over light directions.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "scene/environment_support.h"

namespace latelight::scene {
namespace {

// The integral of D V F (n.l) over the hemisphere of l, in double precision, from the papers' formulas instead of the
// code's: Trowbridge-Reitz, height-correlated Smith, Schlick. `steps` in each of two angles, denser where l mirrors v.
glm::dvec2 quadrature(double nv, double roughness, int steps) {
  const double a2 = std::pow(roughness, 4.0);
  const glm::dvec3 v(std::sqrt(1.0 - nv * nv), 0.0, nv);
  const auto lambda = [&](double c) { return 0.5 * (std::sqrt(1.0 + a2 * (1.0 - c * c) / (c * c)) - 1.0); };
  glm::dvec2 sum(0);
  for (int i = 0; i < steps; ++i) {
    const double t = (i + 0.5) / steps, polar = t * t * std::numbers::pi / 2.0;  // of h
    for (int j = 0; j < steps; ++j) {
      const double turn = (j + 0.5) / steps * std::numbers::pi;
      const glm::dvec3 h(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
      const double vh = glm::dot(v, h), nl = 2.0 * vh * h.z - nv;
      if (vh <= 0.0 || nl <= 0.0) continue;
      const double base = h.z * h.z * (a2 - 1.0) + 1.0;
      const double d = a2 / (std::numbers::pi * base * base);
      const double g = 1.0 / (1.0 + lambda(nl) + lambda(nv));
      // dl = 4 (v.h) dh; both halves of the circle.
      const double measure =
          std::sin(polar) * 2.0 * t * (std::numbers::pi / 2.0 / steps) * (std::numbers::pi / steps) * 2.0;
      const double weight = d * g / (4.0 * nl * nv) * nl * 4.0 * vh * measure;
      const double grazing = std::pow(1.0 - vh, 5.0);
      sum += glm::dvec2(weight * (1.0 - grazing), weight * grazing);
    }
  }
  return sum;
}

class ReflectanceTable : public testing::Test {
 private:
  ScopedVariable caching_{"LATELIGHT_NO_CACHE", "1"};
};

TEST_F(ReflectanceTable, MatchesQuadrature) {
  constexpr uint32_t kSize = 32;
  const std::vector<glm::vec2> table = ggxReflectanceTable(kSize);
  ASSERT_EQ(table.size(), kSize * kSize);
  for (const uint32_t x : {0u, 1u, 3u, 8u, 15u, 31u}) {
    for (const uint32_t y : {3u, 6u, 12u, 20u, 31u}) {
      const glm::dvec2 exact = quadrature((x + 0.5) / kSize, (y + 0.5) / kSize, 800);
      const glm::vec2 found = table[y * kSize + x];
      EXPECT_NEAR(found.x, exact.x, 0.004) << "n.v " << (x + 0.5) / kSize << ", roughness " << (y + 0.5) / kSize;
      EXPECT_NEAR(found.y, exact.y, 0.004) << "n.v " << (x + 0.5) / kSize << ", roughness " << (y + 0.5) / kSize;
    }
  }
}

TEST_F(ReflectanceTable, SmoothSurfacesReflectAsFresnelSays) {
  constexpr uint32_t kSize = 64;
  const std::vector<glm::vec2> table = ggxReflectanceTable(kSize);
  for (uint32_t x = 2; x < kSize; ++x) {  // closer to the horizon, even the smoothest lobe is wide
    const double grazing = std::pow(1.0 - (x + 0.5) / kSize, 5.0);
    EXPECT_NEAR(table[x].x, 1.0 - grazing, 0.002) << x;
    EXPECT_NEAR(table[x].y, grazing, 0.002) << x;
  }
  EXPECT_NEAR(table[kSize - 1].x, 1.0f, 1e-3f);
  EXPECT_NEAR(table[kSize - 1].y, 0.0f, 1e-3f);
}

TEST_F(ReflectanceTable, NothingReflectsMoreThanItReceives) {
  for (const uint32_t size : {1u, 32u, 64u}) {
    for (const glm::vec2& entry : ggxReflectanceTable(size)) {
      EXPECT_GE(entry.x, 0.0f);
      EXPECT_GE(entry.y, 0.0f);
      EXPECT_LE(entry.x + entry.y, 1.001f);
    }
  }
}

TEST_F(ReflectanceTable, ComesFromTheCacheAsItWas) {
  const std::vector<glm::vec2> computed = ggxReflectanceTable(32);
  const TemporaryFolder folder;
  const ScopedVariable home("XDG_CACHE_HOME", folder.path().string()), caching("LATELIGHT_NO_CACHE", "0");
  EXPECT_EQ(ggxReflectanceTable(32), computed);
  EXPECT_EQ(ggxReflectanceTable(32), computed);
  EXPECT_NE(ggxReflectanceTable(16), computed);
  const auto entries = std::filesystem::directory_iterator(folder.path() / "latelight");
  for (const auto& entry : entries) std::filesystem::resize_file(entry.path(), 100);
  EXPECT_EQ(ggxReflectanceTable(32), computed) << "a truncated entry is computed again";
}

}  // namespace
}  // namespace latelight::scene
