// Form factors of the shapes, against closed forms and against rays; and the densities of their samples.
#include <gtest/gtest.h>

#include <random>

#include "area_lights/support.h"
#include "shared/area_samples.h"

namespace latelight::test {
namespace {

using shared::AreaLight;
using shared::AreaSample;
using shared::LobeAxes;
using shared::LtcFit;

constexpr uint32_t kTypes[] = {shared::kLightRect, shared::kLightDisk, shared::kLightSphere, shared::kLightTube};

// The form factor at the origin, for a surface with this normal.
double formFactor(const AreaLight& light, dvec3 normal) {
  return shared::areaIntegral(light, glm::vec3(0), shared::cosineAxes(glm::vec3(glm::normalize(normal)))).z;
}

// A light above the origin that emits down.
AreaLight above(uint32_t type, double height, double x, double y, double z = 1) {
  return shape(type, {0, 0, height}, {x, 0, 0}, {0, y, 0}, {0, 0, z});
}

// The rectangle [0, a] x [0, b] at height 1, seen from below its corner (Howell, A Catalog of Radiation Heat Transfer
// Configuration Factors, B-3).
double cornerOfRectangle(double a, double b) {
  const double p = std::sqrt(1 + a * a), q = std::sqrt(1 + b * b);
  return (a / p * std::atan(b / p) + b / q * std::atan(a / q)) / (2 * M_PI);
}

TEST(FormFactor, OfARectangleAboveItsCenter) {
  for (const double a : {0.01, 0.5, 3.0, 100.0})
    for (const double b : {0.2, 1.0}) {
      const double expected = 4 * cornerOfRectangle(a, b);
      EXPECT_NEAR(formFactor(above(shared::kLightRect, 1, a, b), {0, 0, 1}), expected, 2e-5 * expected);
    }
}

TEST(FormFactor, OfADiskAboveItsCenter) {
  for (const double radius : {1e-3, 0.1, 1.0, 10.0, 1e3}) {
    const double expected = radius * radius / (radius * radius + 1);
    EXPECT_NEAR(formFactor(above(shared::kLightDisk, 1, radius, radius), {0, 0, 1}), expected, 1e-5 * expected);
  }
}

// A disk below a parallel receiver that is moved sideways (Howell, B-12).
TEST(FormFactor, OfADiskToTheSide) {
  for (const double aside : {0.3, 2.0, 20.0})
    for (const double radius : {0.1, 1.0, 5.0}) {
      AreaLight light = above(shared::kLightDisk, 1, radius, radius);
      light.center.x = static_cast<float>(aside);
      const double z = 1 + aside * aside + radius * radius;
      const double expected =
          0.5 * (1 - (z - 2 * radius * radius) / std::sqrt(z * z - 4 * aside * aside * radius * radius));
      EXPECT_NEAR(formFactor(light, {0, 0, 1}), expected, 2e-5 * expected + 1e-8);
    }
}

// sin^2 of its half angle, times the cosine to its center.
TEST(FormFactor, OfASphereAboveTheHorizon) {
  for (const double radius : {1e-3, 0.2, 0.9, 0.999})
    for (const double angle : {0.0, 0.3}) {
      const AreaLight light = above(shared::kLightSphere, 1, radius, radius, radius);
      if (angle + std::asin(radius) > M_PI / 2) continue;
      const double expected = radius * radius * std::cos(angle);
      EXPECT_NEAR(formFactor(light, {std::sin(angle), 0, std::cos(angle)}), expected, 1e-5 * expected);
    }
}

// A sphere whose center is on the horizon (Howell, B-46 at an angle of 90 degrees).
TEST(FormFactor, OfASphereHalfBelowTheHorizon) {
  for (const double radius : {0.1, 0.5, 0.95}) {
    const double cosine = std::sqrt(1 - radius * radius);
    const double expected = (std::asin(radius) - radius * cosine) / M_PI;
    EXPECT_NEAR(formFactor(above(shared::kLightSphere, 1, radius, radius, radius), {1, 0, 0}), expected, 2e-6);
  }
}

// A very long tube spans an angle in the plane across it, whose half angle has the sine radius / distance.
TEST(FormFactor, OfALongTube) {
  for (const double radius : {0.01, 0.3, 0.9})
    EXPECT_NEAR(formFactor(above(shared::kLightTube, 1, 1e4, radius, radius), {0, 0, 1}), radius, 2e-4 * radius);
}

// Along its axis, a tube looks like a disk.
TEST(FormFactor, OfATubeAlongItsAxis) {
  const AreaLight light = shape(shared::kLightTube, {0, 0, 3}, {0, 0, 1}, {0.5, 0, 0}, {0, 0.5, 0});
  EXPECT_NEAR(formFactor(light, {0, 0, 1}), 0.25 / (0.25 + 4), 1e-6);
}

TEST(FormFactor, IsZeroBehindOneSidedLightsAndInsideClosedOnes) {
  for (const uint32_t type : {shared::kLightRect, shared::kLightDisk}) {
    AreaLight light = above(type, 1, 0.5, 0.5, -1);  // emits up
    EXPECT_EQ(formFactor(light, {0, 0, 1}), 0);
    light.twoSided = 1;
    EXPECT_GT(formFactor(light, {0, 0, 1}), 0.1);
    light.center.z = -1;
    EXPECT_EQ(formFactor(light, {0, 0, 1}), 0) << "below the horizon";
    light.center.z = 0;
    EXPECT_EQ(formFactor(light, {0, 0, 1}), 0) << "in the plane of the light";
  }
  for (const uint32_t type : {shared::kLightSphere, shared::kLightTube})
    for (const double height : {0.0, 0.5, 0.99}) EXPECT_EQ(formFactor(above(type, height, 1, 1), {0, 0, 1}), 0) << type;
}

// Distances and sizes over ten orders of magnitude: small lights are punctual lights of their projected area.
TEST(FormFactor, OfDistantLightsFallsWithTheSquare) {
  for (const uint32_t type : kTypes)
    for (const double distance : {30.0, 1e3, 1e5}) {
      const AreaLight light = above(type, distance, 0.5, 0.5, 0.5);
      const double area = type == shared::kLightRect || type == shared::kLightTube ? 1 : M_PI / 4;
      const double expected = area / (M_PI * distance * distance);
      // The near side is closer than the center by the radius.
      EXPECT_NEAR(formFactor(light, {0, 0, 1}) / expected, 1, 0.5 / distance + 1e-4) << type << " at " << distance;
    }
}

// A tube of radius r and length l, whose axis has the angle a to the direction to it, is a punctual light with the area
// 2 r l sin a + pi r^2 cos a. Axes may be left-handed.
TEST(FormFactor, OfASmallTubeIsThatOfItsArea) {
  std::mt19937 engine(1);
  const auto vector = [&] {
    std::uniform_real_distribution one(-1.0, 1.0);
    const double x = one(engine), y = one(engine);
    return dvec3(x, y, one(engine));
  };
  for (const double radius : {1e-5, 1e-4, 1e-3})
    for (const double length : {1e-5, 1e-4, 1e-3}) {
      double worst = 0;
      for (int i = 0; i < 200; ++i) {
        const dvec3 to = glm::normalize(vector()), x = glm::normalize(vector());
        const dvec3 y = glm::normalize(glm::cross(x, vector())), z = glm::cross(x, y) * (i % 2 ? 1.0 : -1.0);
        const dvec3 normal = glm::normalize(to + 0.4 * vector());
        const AreaLight light = shape(shared::kLightTube, to, x * (length / 2), y * radius, z * radius);
        const double along = std::abs(glm::dot(x, to)), across = std::sqrt(1 - along * along);
        const double area = 2 * radius * length * across + M_PI * radius * radius * along;
        const double expected = area * glm::dot(normal, to) / M_PI;
        worst = std::max(worst, std::abs(formFactor(light, normal) / expected - 1));
      }
      EXPECT_LT(worst, 0.015) << radius << " " << length;
    }
}

// --- shapes at random ------------------------------------------------------------------------------------------------

class RandomShapes {
 public:
  double uniform() { return std::uniform_real_distribution(-1.0, 1.0)(engine_); }
  dvec3 vector(double size = 1) { return dvec3(uniform(), uniform(), uniform()) * size; }
  // Sheared and stretched, near and far, one- and two-sided.
  AreaLight shapeOf(uint32_t type) {
    const double size = std::pow(10, uniform() * 0.7);
    const dvec3 center = vector(3), x = vector(size), y = vector(size), z = vector(size);
    AreaLight light = shape(type, center, x, y, z);
    light.twoSided = uniform() > 0;
    return light;
  }
  // Not so flat that few samples find it.
  AreaLight roundShapeOf(uint32_t type) {
    const double size = std::pow(10, uniform() * 0.7 - 0.3);
    const dvec3 center = vector(3), x = glm::normalize(vector()), y = glm::normalize(glm::cross(x, vector()));
    const auto length = [&] { return size * std::exp(0.7 * uniform()); };
    AreaLight light =
        shape(type, center, x * length(), y * length(), glm::cross(x, y) * length() + x * (0.3 * size * uniform()));
    light.twoSided = uniform() > 0;
    return light;
  }

 private:
  std::mt19937 engine_{1};
};

// Rounding of a fraction of so many rays.
constexpr uint32_t kRays = 20'000;
constexpr double kRayError = 1.5e-3;
// Polygons replace the ellipses at the ends of a tube.
double errorOf(uint32_t type) {
  return kRayError + (type == shared::kLightTube ? 8e-3 : 0);
}

TEST(FormFactor, IsTheFractionOfRaysThatSeeTheLight) {
  RandomShapes random;
  for (const uint32_t type : kTypes)
    for (int i = 0; i < 60; ++i) {
      const AreaLight light = random.shapeOf(type);
      const LobeAxes axes = shared::cosineAxes(glm::vec3(glm::normalize(random.vector())));
      const dmat3 toWorld(dvec3(axes.x), dvec3(axes.y), dvec3(axes.z));
      uint32_t seen = 0;
      for (uint32_t k = 0; k < kRays; ++k) seen += sees(light, dvec3(0), toWorld * cosineDirection(latticePoint(k)));
      EXPECT_NEAR(shared::areaIntegral(light, glm::vec3(0), axes).z, double(seen) / kRays, errorOf(type)) << type;
    }
}

// With both horizons: that of the cosine and that of the surface.
TEST(FormFactor, OfATransformedCosineIsTheFractionOfItsRays) {
  RandomShapes random;
  for (const uint32_t type : kTypes)
    for (int i = 0; i < 60; ++i) {
      const AreaLight light = random.shapeOf(type);
      const dvec3 normal = glm::normalize(random.vector());
      dvec3 eye = glm::normalize(random.vector());
      if (glm::dot(eye, normal) < 0) eye = -eye;
      const double tilt = 0.5 * random.uniform();
      const LtcFit fit{static_cast<float>(std::cos(tilt)), static_cast<float>(0.3 * random.uniform()),
                       static_cast<float>(0.5 * std::sin(tilt)), static_cast<float>(0.6 + 0.4 * random.uniform())};
      const LobeAxes axes = shared::fittedAxes(glm::vec3(normal), glm::vec3(eye), fit);
      const dmat3 toWorld = glm::inverse(glm::transpose(dmat3(dvec3(axes.x), dvec3(axes.y), dvec3(axes.z))));
      uint32_t seen = 0, all = 0;
      for (uint32_t k = 0; k < kRays; ++k) {
        const dvec3 direction = toWorld * cosineDirection(latticePoint(k));
        if (glm::dot(direction, normal) <= 0) continue;
        ++all;
        seen += sees(light, dvec3(0), direction);
      }
      EXPECT_NEAR(shared::lobeShare(light, glm::vec3(0), axes), double(seen) / all, errorOf(type)) << type;
      EXPECT_NEAR(1 / axes.scale, double(all) / kRays, kRayError);
    }
}

TEST(AreaSamples, IntegrateToTheFormFactor) {
  RandomShapes random;
  for (const uint32_t type : kTypes)
    for (int i = 0; i < 60; ++i) {
      const AreaLight light = random.roundShapeOf(type);
      const glm::vec3 normal(glm::normalize(random.vector()));
      double sum = 0;
      for (uint32_t k = 0; k < kRays; ++k) {
        const AreaSample s = shared::sampleArea(light, glm::vec3(0), glm::vec2(latticePoint(k)));
        if (s.density > 0) sum += std::max(0.0f, glm::dot(normal, s.toLight)) / s.density / M_PI;
      }
      const double expected = shared::areaIntegral(light, glm::vec3(0), shared::cosineAxes(normal)).z;
      EXPECT_NEAR(sum / kRays, expected, errorOf(type) + 0.01 * expected) << type << " " << i;
    }
}

// Multiple importance sampling needs the density of samples in the directions of other rays.
TEST(AreaSamples, AreHitWithTheirDensity) {
  RandomShapes random;
  for (const uint32_t type : kTypes) {
    uint32_t all = 0, missed = 0;
    for (int i = 0; i < 60; ++i) {
      const AreaLight light = random.roundShapeOf(type);
      for (uint32_t k = 0; k < 100; ++k) {
        const AreaSample s = shared::sampleArea(light, glm::vec3(0), glm::vec2(latticePoint(k)));
        if (!(s.density > 0)) continue;
        const AreaSample hit = shared::hitArea(light, glm::vec3(0), s.toLight);
        ++all;
        missed += !(hit.density > 0);  // at the very edge
        if (!(hit.density > 0)) continue;
        EXPECT_NEAR(hit.distance / s.distance, 1, 2e-3) << type;
        if (type == shared::kLightTube && hit.density > 1e3f) continue;  // at the tangents, where it is infinite
        EXPECT_NEAR(hit.density / s.density, 1, type == shared::kLightTube ? 0.1 : 0.02) << type;
      }
    }
    EXPECT_GT(all, 3000u) << type;
    EXPECT_LT(missed, all / 500) << type;
  }
}

// A rectangle is sampled uniformly in solid angle, and a sphere, too.
TEST(AreaSamples, OfRectanglesAndSpheresAreUniformInSolidAngle) {
  const AreaLight rect = above(shared::kLightRect, 1, 2, 1);
  // The solid angle of a rectangle above its center.
  const double solidAngle = 4 * std::asin(2 * 1 / std::sqrt((1 + 4.0) * (1 + 1.0)));
  const AreaLight sphere = above(shared::kLightSphere, 2, 1, 1, 1);
  for (uint32_t k = 0; k < 50; ++k) {
    const glm::vec2 u(latticePoint(k));
    EXPECT_NEAR(shared::sampleArea(rect, glm::vec3(0), u).density * solidAngle, 1, 1e-4);
    EXPECT_NEAR(shared::sampleArea(sphere, glm::vec3(0), u).density * 2 * M_PI * (1 - std::sqrt(0.75)), 1, 1e-4);
  }
}

}  // namespace
}  // namespace latelight::test
