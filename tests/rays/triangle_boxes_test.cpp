// Boxes of triangles, and of their parts.
#include "render/rays/triangle_boxes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "rays/slivers.h"
#include "render/support.h"

namespace latelight::render::test {
namespace {

double areaOf(const TriangleBoxes& boxes) {
  double area = 0;
  for (const Box& box : boxes.boxes) area += halfArea(box);
  return area;
}

TriangleBoxes wholeBoxes(const scene::Mesh& mesh) {
  TriangleBoxes whole;
  for (size_t i = 0; i < mesh.indices.size(); ++i) {
    if (i % 3 == 0) whole.boxes.emplace_back();
    whole.boxes.back().add(mesh.positions[mesh.indices[i]] - scene::vertexOrigin(mesh));
  }
  return whole;
}

// Every tenth triangle is long.
scene::Mesh needles(size_t count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-4, 4), offset(-0.02f, 0.02f);
  scene::Mesh mesh;
  const auto point = [&](auto& of) { return glm::vec3(of(random), of(random), of(random)); };
  for (size_t i = 0; i < count; ++i) {
    const glm::vec3 a = point(place), b = i % 10 ? a + 4.0f * point(offset) : point(place);
    for (const glm::vec3 corner : {a, b, b + point(offset)}) {
      mesh.indices.push_back(static_cast<uint32_t>(mesh.positions.size()));
      mesh.positions.push_back(corner);
    }
  }
  scene::findBounds(mesh);
  return mesh;
}

TEST(TriangleBoxes, ContainTheirTriangle) {
  for (const scene::Mesh& mesh : {needles(2000), sliverTube(64, 20)}) {
    const TriangleBoxes boxes = triangleBoxes(mesh);
    const size_t triangles = mesh.indices.size() / 3;
    ASSERT_EQ(boxes.triangles.size(), boxes.boxes.size());
    EXPECT_GT(boxes.boxes.size(), triangles);
    EXPECT_LE(boxes.boxes.size(), triangles * 12 / 10);
    EXPECT_LE(areaOf(boxes), 0.75 * areaOf(wholeBoxes(mesh)));
    std::vector<std::vector<Box>> of(triangles);
    for (size_t i = 0; i < boxes.boxes.size(); ++i) of[boxes.triangles[i]].push_back(boxes.boxes[i]);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform;
    size_t outside = 0;
    for (size_t i = 0; i < triangles; ++i)
      for (int sample = 0; sample < 64; ++sample) {
        const double side = std::sqrt(uniform(random)), v = uniform(random);
        const glm::dvec3 weights(1 - side, side * (1 - v), side * v);
        glm::dvec3 point(0);
        for (int k = 0; k < 3; ++k)
          point += weights[k] * glm::dvec3(mesh.positions[mesh.indices[3 * i + k]] - scene::vertexOrigin(mesh));
        const bool inside = std::ranges::any_of(of[i], [&](const Box& box) {
          return glm::all(glm::greaterThanEqual(point, glm::dvec3(box.low))) &&
                 glm::all(glm::lessThanEqual(point, glm::dvec3(box.high)));
        });
        outside += !inside;
      }
    EXPECT_EQ(outside, 0u);
  }
}

TEST(TriangleBoxes, StayWholeWhereDivisionSavesLittle) {
  for (const scene::Mesh& mesh : {sphereMesh(3), deformedTube()}) {
    const TriangleBoxes boxes = triangleBoxes(mesh), whole = wholeBoxes(mesh);
    EXPECT_TRUE(boxes.triangles.empty());
    ASSERT_EQ(boxes.boxes.size(), whole.boxes.size());
    for (size_t i = 0; i < whole.boxes.size(); ++i) {
      EXPECT_EQ(boxes.boxes[i].low, whole.boxes[i].low);
      EXPECT_EQ(boxes.boxes[i].high, whole.boxes[i].high);
    }
  }
}

// Points, lines, planes, and sizes at the limits of floats.
TEST(TriangleBoxes, HandleDegenerateMeshes) {
  for (const float size : {0.0f, 1e-40f, 1e-20f, 1e18f, 3e38f})
    for (const glm::vec3 axes : {glm::vec3(1), glm::vec3(1, 0, 0), glm::vec3(1, 1, 0)}) {
      scene::Mesh mesh = needles(100);
      for (glm::vec3& position : mesh.positions) position *= 0.2f * size * axes;
      scene::findBounds(mesh);
      const TriangleBoxes boxes = triangleBoxes(mesh);
      ASSERT_GE(boxes.boxes.size(), 100u);
      EXPECT_LE(boxes.boxes.size(), 120u);
      for (const Box& box : boxes.boxes) EXPECT_FALSE(glm::any(glm::greaterThan(box.low, box.high)));
    }
}

}  // namespace
}  // namespace latelight::render::test
