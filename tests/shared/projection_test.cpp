#include "shared/projection.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "shared/random.h"

namespace latelight::shared {
namespace {

using Row = std::array<double, 4>;
using Matrix = std::array<Row, 4>;

Row operator*(const Row& v, const Matrix& m) {
  Row r{};
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) r[column] += v[row] * m[row][column];
  return r;
}

// The matrix for row vectors on the left; the principal point is added in the column of w, which is y.
Matrix rowVectorMatrix(const Projection& p) {
  return {{{p.H, 0, 0, 0}, {p.X, p.Z, p.A, 1}, {0, p.V, 0, 0}, {0, 0, p.B, 0}}};
}

// The inverse of a centered projection.
Matrix rowVectorInverse(const Projection& p) {
  const double H = p.H, V = p.V, A = p.A, B = p.B;
  return {{{1 / H, 0, 0, 0}, {0, 0, 1 / V, 0}, {0, 0, 0, 1 / B}, {0, 1, 0, -A / B}}};
}

struct Case {
  std::string name;
  Projection projection;
  double near, far;  // in meters; far is infinite if there is none
};

// Device depth 0 or 1 at the near plane and its opposite at the far plane, solved from depth = A + B / y.
Projection perspective(double H, double V, double atNear, double near, double far) {
  const bool infinite = std::isinf(far);
  const double atFar = 1.0 - atNear;
  const double B = infinite ? (atNear - atFar) * near : (atNear - atFar) / (1.0 / near - 1.0 / far);
  const double A = infinite ? atFar : atNear - B / near;
  return {float(H), float(V), float(A), float(B), 0.0f, 0.0f, kPerspective};
}

Projection orthographic(double H, double V, double atNear, double near, double far) {
  const double A = (1.0 - 2.0 * atNear) / (far - near);
  return {float(H), float(V), float(A), float(atNear - A * near), 0.0f, 0.0f, kOrthographic};
}

std::vector<Case> cases() {
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<Case> list = {
      {"conventional", perspective(1.2, 2.1, 0.0, 0.1, 100.0), 0.1, 100.0},
      {"reversed", perspective(1.2, 2.1, 1.0, 0.1, 100.0), 0.1, 100.0},
      {"conventional infinite", perspective(1.2, 2.1, 0.0, 0.1, infinity), 0.1, infinity},
      {"reversed infinite", perspective(1.2, 2.1, 1.0, 0.1, infinity), 0.1, infinity},
      {"orthographic conventional", orthographic(0.25, 0.5, 0.0, 0.1, 100.0), 0.1, 100.0},
      {"orthographic reversed", orthographic(0.25, 0.5, 1.0, 0.1, 100.0), 0.1, 100.0},
  };
  for (size_t i = 0, count = list.size(); i < count; ++i) {
    Case c = list[i];
    c.name += ", off-center";
    c.projection.X = 0.3f;
    c.projection.Z = -0.2f;
    list.push_back(c);
  }
  return list;
}

vec3 pointInView(Random& random, const Case& c) {
  const float depth = random.logUniform(float(c.near), std::isinf(c.far) ? 1000.0f : float(c.far));
  return viewPositionAtDepth(c.projection, vec2(random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f)), depth);
}

// The change of view depth in meters that one rounding of device depth causes, which bounds every round trip.
double depthStep(const Projection& p, double depth) {
  const double slope = p.kind == kPerspective ? depth * depth / std::abs(p.B) : 1.0 / std::abs(p.A);
  return 4.0 * 0x1p-24 * slope + 1e-6 * depth;
}

TEST(Projection, MatchesSeedsMatrix) {
  Random random(1);
  for (const Case& c : cases()) {
    if (c.projection.kind != kPerspective) continue;
    for (int i = 0; i < 1000; ++i) {
      const vec3 v = pointInView(random, c);
      const vec4 clip = projectToClip(c.projection, v);
      const Row expected = Row{v.x, v.y, v.z, 1.0} * rowVectorMatrix(c.projection);
      const double scale = std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
      EXPECT_NEAR(clip.x, expected[0], 1e-6 * scale) << c.name;
      EXPECT_NEAR(clip.y, expected[1], 1e-6 * scale) << c.name;
      EXPECT_NEAR(clip.z, expected[2], 1e-6 * scale) << c.name;
      EXPECT_EQ(clip.w, v.y) << c.name;
    }
  }
}

// The inverse matrix, and the multiply-add and reciprocal 1 / (P d + Q) with P = 1 / B and Q = -A / B.
TEST(Projection, InverseMatchesItsThreeForms) {
  Random random(2);
  for (const Case& c : cases()) {
    const Projection& p = c.projection;
    if (p.kind != kPerspective || p.X != 0.0f) continue;
    for (int i = 0; i < 1000; ++i) {
      const vec2 ndc(random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f));
      const float depth = deviceDepth(p, random.logUniform(float(c.near), 50.0f));
      const Row homogeneous = Row{ndc.x, ndc.y, depth, 1.0} * rowVectorInverse(p);
      const double y = homogeneous[1] / homogeneous[3];
      const vec3 v = viewPositionAtDepth(p, ndc, viewDepth(p, depth));
      const double tolerance = depthStep(p, y);
      EXPECT_NEAR(v.x, homogeneous[0] / homogeneous[3], tolerance * std::abs(ndc.x / p.H) + 1e-6) << c.name;
      EXPECT_NEAR(v.y, y, tolerance) << c.name;
      EXPECT_NEAR(v.z, homogeneous[2] / homogeneous[3], tolerance * std::abs(ndc.y / p.V) + 1e-6) << c.name;
      EXPECT_NEAR(viewDepth(p, depth), 1.0 / (depth / double(p.B) - double(p.A) / p.B), tolerance) << c.name;
    }
  }
}

// The three methods compared with the same in double precision, through the float's device depth. Ray and matrix follow
// the formulas after which they are named, as do P and Q, which are rounded: if A is near 1 and d near A, their
// rounding matters.
TEST(Projection, PositionMethodsAgree) {
  Random random(6);
  for (const Case& c : cases()) {
    const Projection& p = c.projection;
    for (int i = 0; i < 1000; ++i) {
      const vec2 ndc(random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f));
      const float d = deviceDepth(p, random.logUniform(float(c.near), 50.0f));
      const double y = p.kind == kPerspective ? p.B / (double(d) - p.A) : (double(d) - p.B) / p.A;
      const double w = p.kind == kPerspective ? y : 1.0;
      const double x = (double(ndc.x) - p.X) * w / p.H, z = (double(ndc.y) - p.Z) * w / p.V;
      const double scale = 1.0 + std::abs(x / y) + std::abs(z / y);
      for (const uint method : {kPositionRay, kPositionMatrix, kPositionReciprocal}) {
        const vec3 v = viewPosition(p, method, ndc, d);
        const double error = std::hypot(v.x - x, std::hypot(v.y - y, v.z - z));
        EXPECT_LE(error, scale * depthStep(p, y) + 1e-6) << c.name << ", method " << method << " at " << y;
      }
    }
  }
}

TEST(Projection, InverseMatrixUndoesTheProjection) {
  Random random(7);
  for (const Case& c : cases()) {
    const InverseProjection m = inverseProjection(c.projection);
    for (int i = 0; i < 100; ++i) {
      const vec3 v = pointInView(random, c);
      const vec4 clip = projectToClip(c.projection, v);
      const vec4 h = m.x * clip.x + m.y * clip.y + m.z * clip.z + m.w * clip.w;
      const double scale = length(v) / std::abs(c.projection.kind == kPerspective ? c.projection.B : 1.0f);
      EXPECT_NEAR(h.x, v.x, 1e-5 * length(v)) << c.name;
      EXPECT_NEAR(h.z, v.z, 1e-5 * length(v)) << c.name;
      EXPECT_NEAR(h.w, 1.0, 1e-6 * scale + 1e-6) << c.name;
    }
  }
}

TEST(Projection, NearAndFarPlanesGetTheirDeviceDepths) {
  for (const Case& c : cases()) {
    const bool reversed = c.name.find("reversed") != std::string::npos;
    EXPECT_NEAR(deviceDepth(c.projection, float(c.near)), reversed ? 1.0f : 0.0f, 1e-5f) << c.name;
    if (std::isinf(c.far)) {
      EXPECT_TRUE(std::isinf(viewDepth(c.projection, reversed ? 0.0f : 1.0f))) << c.name;
    } else {
      EXPECT_NEAR(deviceDepth(c.projection, float(c.far)), reversed ? 0.0f : 1.0f, 1e-5f) << c.name;
    }
  }
}

TEST(Projection, PointsComeBackFromDeviceCoordinates) {
  Random random(3);
  for (const Case& c : cases()) {
    for (int i = 0; i < 1000; ++i) {
      const vec3 v = pointInView(random, c);
      const vec4 clip = projectToClip(c.projection, v);
      const vec2 ndc(clip.x / clip.w, clip.y / clip.w);
      const vec3 back = viewPositionAtDepth(c.projection, ndc, viewDepth(c.projection, clip.z / clip.w));
      const double tolerance = 3.0 * depthStep(c.projection, v.y);
      EXPECT_LE(length(back - v), tolerance + 1e-6 * length(v)) << c.name << " at depth " << v.y;
    }
  }
}

TEST(Projection, ReversedDepthOfAnInfiniteViewLosesNothing) {
  const Projection p = perspective(1.0, 1.0, 1.0, 0.1, std::numeric_limits<double>::infinity());
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const float depth = random.logUniform(0.1f, 1e7f);
    EXPECT_NEAR(viewDepth(p, deviceDepth(p, depth)), depth, 2e-7f * depth);
  }
}

TEST(Projection, RayPassesThroughThePointSeen) {
  Random random(5);
  for (const Case& c : cases()) {
    for (int i = 0; i < 100; ++i) {
      const vec2 ndc(random.uniform(-1.0f, 1.0f), random.uniform(-1.0f, 1.0f));
      const vec3 ray = viewRay(c.projection, ndc);
      EXPECT_EQ(ray.y, 1.0f);
      const vec3 near = viewPositionAtDepth(c.projection, ndc, 2.0f);
      const vec3 far = viewPositionAtDepth(c.projection, ndc, 5.0f);
      EXPECT_LE(length(near + ray * 3.0f - far), 1e-5f) << c.name;
    }
  }
}

TEST(Projection, PixelRowsRunDown) {
  const vec2 size(640.0f, 480.0f);
  EXPECT_EQ(pixelToNdc(vec2(0.0f, 0.0f), size), vec2(-1.0f, 1.0f));
  EXPECT_EQ(pixelToNdc(vec2(640.0f, 480.0f), size), vec2(1.0f, -1.0f));
  EXPECT_EQ(pixelToNdc(vec2(320.0f, 120.0f), size), vec2(0.0f, 0.5f));
}

}  // namespace
}  // namespace latelight::shared
