// The output `curvature` compared with the closed forms of a sphere, a cylinder, a torus and an ellipsoid.
#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "render/support.h"
#include "test_device.h"

namespace latelight::test {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kTurn = 2 * std::numbers::pi;

// A grid of (columns + 1) x (rows + 1) vertices, whose seams and poles have several vertices at one position.
MeshData gridMesh(uint32_t columns, uint32_t rows, const std::function<dvec3(double, double)>& at) {
  MeshData mesh{.name = "grid"};
  for (uint32_t j = 0; j <= rows; ++j)
    for (uint32_t i = 0; i <= columns; ++i) {
      const dvec3 p = at(i == columns ? 0 : double(i) / columns, double(j) / rows);
      mesh.positions.push_back({float(p.x), float(p.y), float(p.z)});
    }
  for (uint32_t j = 0; j < rows; ++j)
    for (uint32_t i = 0; i < columns; ++i) {
      const uint32_t a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
      for (const uint32_t index : {a, c, b, b, c, d}) mesh.indices.push_back(index);
    }
  return mesh;
}

dvec3 onSphere(double u, double v) {
  const double longitude = kTurn * u, polar = kTurn / 2 * v;
  if (v == 0 || v == 1) return {0, v == 0 ? 1 : -1, 0};
  return {std::sin(polar) * std::sin(longitude), std::cos(polar), std::sin(polar) * std::cos(longitude)};
}

struct Curvatures {
  std::vector<dvec2> values;     // mean and Gaussian, of the pixels that show the object
  std::vector<dvec3> positions;  // object-position
};

class CurvatureTest : public testing::TestWithParam<const char*> {
 protected:
  static Curvatures render(const MeshData& mesh, const Transform& transform, std::array<double, 3> eye) {
    Scene scene;
    scene.addInstance(scene.addMesh(mesh), scene.addMaterial(Material{.name = "plain", .doubleSided = true}),
                      transform);
    Renderer renderer(scene, testDevice());
    Options options;
    options.width = options.height = 96;
    options.raster = GetParam();
    options.picture = false;
    options.aovs = {"curvature", "object-position", "id"};
    const Frame frame = renderer.render(scene.lookAt(eye, {0, 0, 0}, 30), options);
    EXPECT_EQ(renderer.validationMessages(), std::vector<std::string>{});
    Curvatures found;
    const std::vector<float>&c = frame.aovs.at("curvature").values, &p = frame.aovs.at("object-position").values;
    for (size_t i = 0; i < 96 * 96; ++i) {
      if (frame.aovs.at("id").ids[i] == 0) {
        EXPECT_EQ(c[2 * i], 0);
        continue;
      }
      found.values.emplace_back(c[2 * i], c[2 * i + 1]);
      found.positions.emplace_back(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
    }
    EXPECT_GT(found.values.size(), 500u);
    return found;
  }

  // Expects the values of a function of the position, within a share of `scale` at almost all pixels.
  static void expect(const Curvatures& found, const std::function<dvec2(dvec3)>& closedForm, dvec2 scale,
                     double tolerance) {
    size_t off = 0;
    for (size_t i = 0; i < found.values.size(); ++i) {
      const dvec2 error = glm::abs(found.values[i] - closedForm(found.positions[i])) / scale;
      off += error.x > tolerance || error.y > tolerance;
    }
    EXPECT_LE(off, found.values.size() / 50);
  }
};

constexpr Transform kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

TEST_P(CurvatureTest, Sphere) {
  // Scaled to a radius of 2 m, also by a mirror.
  for (const double mirror : {1.0, -1.0}) {
    const Transform twice{2 * mirror, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1};
    expect(
        render(gridMesh(96, 48, onSphere), twice, {4, 6, 9}), [](dvec3) { return dvec2(0.5, 0.25); }, {0.5, 0.25},
        0.02);
  }
}

TEST_P(CurvatureTest, TheInsideOfASphereIsHollow) {
  MeshData mesh = gridMesh(96, 48, onSphere);
  for (size_t i = 0; i < mesh.indices.size(); i += 3) std::swap(mesh.indices[i], mesh.indices[i + 1]);
  expect(
      render(mesh, kIdentity, {0.2, 0, 0.1}), [](dvec3) { return dvec2(-1, 1); }, {1, 1}, 0.02);
}

TEST_P(CurvatureTest, AnEllipsoidByScale) {
  const dvec3 axes(1.5, 1, 0.8);
  const Transform scale{axes.x, 0, 0, 0, 0, axes.y, 0, 0, 0, 0, axes.z, 0, 0, 0, 0, 1};
  const auto closedForm = [&](dvec3 p) {
    const dvec3 squares = axes * axes;
    const double s = glm::dot(p * p, 1.0 / (squares * squares)), product = squares.x * squares.y * squares.z;
    const double sum = squares.x + squares.y + squares.z;
    return dvec2(std::abs(glm::dot(p, p) - sum) / (2 * product * std::pow(s, 1.5)), 1 / (product * s * s));
  };
  expect(render(gridMesh(160, 80, onSphere), scale, {3, 4, 6}), closedForm, {1, 1}, 0.03);
}

// Its edges are boundaries, whose vertices have the values of their neighbors.
TEST_P(CurvatureTest, AnOpenCylinder) {
  const MeshData mesh = gridMesh(96, 20, [](double u, double v) {
    return dvec3(0.5 * std::sin(kTurn * u), 1 - 2 * v, 0.5 * std::cos(kTurn * u));
  });
  expect(
      render(mesh, kIdentity, {3, 0.5, 4}), [](dvec3) { return dvec2(1, 0); }, {1, 4}, 0.02);
}

TEST_P(CurvatureTest, Torus) {
  constexpr double kMajor = 1, kMinor = 0.4;
  const MeshData mesh = gridMesh(120, 60, [&](double u, double v) {
    const double tube = v == 1 ? 0 : -kTurn * v, radius = kMajor + kMinor * std::cos(tube);
    return dvec3(radius * std::sin(kTurn * u), kMinor * std::sin(tube), radius * std::cos(kTurn * u));
  });
  const auto closedForm = [&](dvec3 p) {
    const double radius = std::hypot(p.x, p.z), cosine = (radius - kMajor) / kMinor;
    return dvec2((kMajor + 2 * kMinor * cosine) / (2 * kMinor * radius), cosine / (kMinor * radius));
  };
  const Curvatures found = render(mesh, kIdentity, {1, 4, 4});
  expect(found, closedForm, {1.6, 1.8}, 0.03);
  EXPECT_LT(std::ranges::min(found.values, {}, [](dvec2 c) { return c.y; }).y, -1);  // the inner side is a saddle
}

TEST_P(CurvatureTest, BoundariesWithoutOtherNeighborsAreZero) {
  const MeshData square{
      .name = "square", .positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, .indices = {0, 1, 2, 0, 2, 3}};
  for (const dvec2 value : render(square, kIdentity, {0, 0, 5}).values) EXPECT_EQ(value, dvec2(0));
}

INSTANTIATE_TEST_SUITE_P(Rasters, CurvatureTest, testing::Values("hardware", "compute"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace latelight::test
