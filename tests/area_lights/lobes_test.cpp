// Light through the specular lobe: the fitted lobes against the renderer's BRDF, integrated by its visible normals.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "area_lights/support.h"
#include "render/gpu_scene/ltc_table.h"
#include "shared/shade_area.h"

namespace latelight::test {
namespace {

using shared::AreaLight;

// Directions in proportion to the lobe of a white mirror-like surface with the normal +Z, and their weights, whose sum
// is the reflected fraction of uniform light.
struct Lobe {
  std::vector<dvec3> directions;
  std::vector<double> weights;
  double albedo = 0;
};

shared::SurfaceBrdf mirrorBrdf(float roughness, dvec3 eye) {
  shared::Surface s = shared::emptySurface();
  s.roughness = roughness;
  s.metallic = 1;
  s.baseColor = glm::vec3(1);
  s.f0 = glm::vec3(1);
  s.f90 = 1;
  return shared::surfaceBrdf(s, glm::vec3(eye), shared::kShadingGgx);
}

Lobe lobeOf(float roughness, dvec3 eye) {
  constexpr uint32_t kCount = 30'000;
  const shared::SurfaceBrdf brdf = mirrorBrdf(roughness, eye);
  const double alpha = shared::ggxAlpha(roughness);
  const dvec3 stretched = glm::normalize(dvec3(eye.x * alpha, eye.y * alpha, eye.z));
  Lobe lobe;
  for (uint32_t i = 0; i < kCount; ++i) {
    const dvec2 u = latticePoint(i);
    const double z = 1 - u.y * (1 + stretched.z), radius = std::sqrt(std::max(1 - z * z, 0.0)), turn = 2 * M_PI * u.x;
    const dvec3 cap = dvec3(radius * std::cos(turn), radius * std::sin(turn), z) + stretched;
    const dvec3 half = glm::normalize(dvec3(cap.x * alpha, cap.y * alpha, std::max(cap.z, 1e-9)));
    const dvec3 light = half * (2 * glm::dot(half, eye)) - eye;
    if (light.z <= 0) continue;
    const double sine2 = half.x * half.x + half.y * half.y, slope = half.z * half.z * alpha * alpha + sine2;
    const double distribution = alpha * alpha / (M_PI * slope * slope);
    const double root = std::sqrt(alpha * alpha + (1 - alpha * alpha) * eye.z * eye.z);
    const double density = distribution / (2 * (eye.z + root));
    const glm::vec3 sent = shared::shadeLight(brdf, {glm::vec3(light), glm::vec3(1), 1}, shared::kShadingGgx);
    lobe.directions.push_back(light);
    lobe.weights.push_back(sent.x / density / kCount);
    lobe.albedo += lobe.weights.back();
  }
  return lobe;
}

struct Errors {
  double worst = 0, squares = 0;
  int count = 0;
  double mean() const { return std::sqrt(squares / count); }
};

// Rectangles about the mirrored direction, from a tenth of the lobe's width to most of the hemisphere.
Errors errorsOf(float roughness, double nv) {
  const dvec3 eye(std::sqrt(1 - nv * nv), 0, nv);
  const Lobe lobe = lobeOf(roughness, eye);
  const shared::LobeAxes axes =
      shared::fittedAxes(glm::vec3(0, 0, 1), glm::vec3(eye), render::lobeFit(static_cast<float>(nv), roughness));
  std::mt19937 engine(7);
  const auto uniform = [&] { return std::uniform_real_distribution(-1.0, 1.0)(engine); };
  Errors errors;
  for (int i = 0; i < 40; ++i) {
    const dvec3 aside = dvec3(uniform(), uniform(), uniform()) * (0.1 + double{roughness});
    const dvec3 center = glm::normalize(dvec3(-eye.x, 0, eye.z) + aside);
    const double size = std::pow(10, -0.7 + 0.8 * uniform());
    const dvec3 x = glm::normalize(glm::cross(center, dvec3(uniform(), uniform(), 0.3)));
    AreaLight light =
        shape(i % 2 ? shared::kLightRect : shared::kLightDisk, center, x * size, glm::cross(x, center) * size, center);
    light.twoSided = 1;
    double expected = 0;
    for (size_t k = 0; k < lobe.directions.size(); ++k)
      if (sees(light, dvec3(0), lobe.directions[k])) expected += lobe.weights[k];
    const double error = std::abs(shared::lobeShare(light, glm::vec3(0), axes) * lobe.albedo - expected);
    errors.worst = std::max(errors.worst, error);
    errors.squares += error * error;
    ++errors.count;
  }
  return errors;
}

// The errors of docs/light.md, as fractions of the light of a uniform environment.
TEST(FittedLobes, MatchTheBrdf) {
  fmt::print("| roughness |");
  for (const double nv : {1.0, 0.7, 0.5, 0.3, 0.15}) fmt::print(" n.v {} |", nv);
  fmt::print("\n");
  for (const float roughness : {0.05f, 0.1f, 0.2f, 0.3f, 0.5f, 0.7f, 1.0f}) {
    fmt::print("| {} |", roughness);
    for (const double nv : {1.0, 0.7, 0.5, 0.3, 0.15}) {
      const Errors errors = errorsOf(roughness, nv);
      fmt::print(" {:.4f}, {:.4f} |", errors.mean(), errors.worst);
      EXPECT_LT(errors.mean(), nv >= 0.5 ? 0.008 : nv >= 0.3 ? 0.01 : 0.02) << roughness << " " << nv;
      EXPECT_LT(errors.worst, nv >= 0.3 ? 0.03 : 0.05) << roughness << " " << nv;
    }
    fmt::print("\n");
  }
}

// Light from the whole hemisphere is what the split-sum table states, and light from below the surface is none.
TEST(FittedLobes, EndAtTheHorizon) {
  for (const float roughness : {0.1f, 0.5f, 0.8f})
    for (const double nv : {1.0, 0.4, 0.05}) {
      const glm::vec3 eye(std::sqrt(1 - nv * nv), 0, nv);
      const shared::LobeAxes axes =
          shared::fittedAxes(glm::vec3(0, 0, 1), eye, render::lobeFit(static_cast<float>(nv), roughness));
      AreaLight light = shape(shared::kLightRect, {0, 0, 1e-3}, {1e3, 0, 0}, {0, 1e3, 0}, {0, 0, 1});
      EXPECT_NEAR(shared::lobeShare(light, glm::vec3(0), axes), 1, 1e-3);
      light.center.z = -1e-3f;
      light.twoSided = 1;
      EXPECT_NEAR(shared::lobeShare(light, glm::vec3(0), axes), 0, 1e-6);
    }
}

TEST(FittedLobes, AreTheTablesAtItsPoints) {
  const auto table = render::ltcTable();
  ASSERT_EQ(table.size(), size_t{shared::kLtcSize} * shared::kLtcSize);
  for (const uint32_t row : {0u, 11u, 31u})
    for (const uint32_t column : {0u, 7u, 31u}) {
      const float x = static_cast<float>(column) / 31;
      const shared::LtcFit fit = render::lobeFit(1 - x * x, static_cast<float>(row) / 31);
      EXPECT_NEAR(fit.a, table[row * 32 + column].a, 1e-4f);
      EXPECT_NEAR(fit.d, table[row * 32 + column].d, 1e-4f);
    }
}

}  // namespace
}  // namespace latelight::test
