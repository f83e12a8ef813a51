// Compares every method with sorts and sums of its own layers on the CPU.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "long_tests.h"
#include "shared/color.h"
#include "shared/random.h"
#include "transparency/scenes.h"

namespace latelight::render::test {
namespace {

using glm::dvec4;
using output::Aov;

constexpr double kStep = 1.0 / 255;

class Layers : public RenderTest {
 protected:
  // The linear picture, premultiplied.
  static std::vector<vec4> linear(const scene::Scene& scene, uint32_t size, const std::string& method,
                                  uint32_t superSampling = 1) {
    Settings settings = settingsOf(size, size, {Aov::Color});
    settings.transparency = choiceNamed<TransparencyMethod>(method).value();
    settings.aa.superSampling = superSampling;
    return pixelsOf(renderOne(device(), scene, frontCamera(), settings));
  }
  static std::vector<vec4> pixelsOf(const output::FrameOutput& frame) {
    const std::vector<float>& values = imageOf(frame, Aov::Color).values;
    std::vector<vec4> pixels(values.size() / 4);
    for (size_t i = 0; i < pixels.size(); ++i)
      pixels[i] = {values[4 * i], values[4 * i + 1], values[4 * i + 2], values[4 * i + 3]};
    return pixels;
  }
};

double apart(const vec4& a, const dvec4& b) {
  const glm::dvec4 d = glm::abs(dvec4(a) - b);
  return std::max({d.x, d.y, d.z, d.w});
}

vec4 randomColor(shared::Random& random, float leastAlpha = 0.05f) {
  return {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1), random.uniform(leastAlpha, 0.9f)};
}

// --- a staircase: column x has x + 1 layers; a wall hides the farthest of them from the lower half ------------------

constexpr uint32_t kColumns = 32;

struct Staircase {
  Stack stack;
  std::vector<Layer> layers;  // the i-th begins at column i
  vec3 wall{0.2f, 0.5f, 0.1f};
  double wallZ = -1.5;

  explicit Staircase(bool oneColor = false) {
    shared::Random random(3);
    const vec4 only(0.7f, 0.3f, 0.5f, 0.2f);
    for (uint32_t i = 0; i < kColumns; ++i) {
      // A permutation, so that depth is independent of the order in which layers are drawn.
      const double z = i == 0 ? -1.75 : -1.25 + 2.5 * ((i * 11) % kColumns) / kColumns;
      layers.push_back({z, oneColor ? only : randomColor(random)});
      const float left = -1 + 2.0f * static_cast<float>(i) / kColumns, half = (1.1f - left) / 2;
      stack.square(stack.glass(layers.back().color), {left + half, 0, z}, {half, 1.1f});
    }
    stack.square(stack.solid(wall), {0, -0.55f, wallZ}, {1.1f, 0.55f});
  }
  dvec4 expected(uint32_t x, uint32_t y) const {
    const bool low = y >= kColumns / 2;
    std::vector<Layer> seen;
    for (uint32_t i = 0; i <= x; ++i)
      if (!low || layers[i].z > wallZ) seen.push_back(layers[i]);
    return blendInOrder(seen, low ? dvec4(wall, 1) : dvec4(0));
  }
};

TEST_F(Layers, OneToThirtyTwoAgreeWithAnExactSort) {
  const Staircase stairs;
  const std::vector<vec4> picture = linear(stairs.stack.scene, kColumns, "exact");
  double worst = 0;
  for (uint32_t y = 0; y < kColumns; ++y)
    for (uint32_t x = 0; x < kColumns; ++x) {
      const double difference = apart(picture[y * kColumns + x], stairs.expected(x, y));
      ASSERT_LE(difference, kStep) << x + 1 << " layers, row " << y;
      worst = std::max(worst, difference);
    }
  fmt::print("1 to {} layers: at most {:.2f} / 255 apart\n", kColumns, worst * 255);
}

TEST_F(Layers, SortedIsExactWhereNothingInterpenetrates) {
  const Staircase stairs;
  const std::vector<vec4> exact = linear(stairs.stack.scene, kColumns, "exact");
  const std::vector<vec4> sorted = linear(stairs.stack.scene, kColumns, "sorted");
  for (size_t i = 0; i < exact.size(); ++i) ASSERT_LE(apart(sorted[i], dvec4(exact[i])), kStep) << i;
}

// If all layers have one color, the weighted mean is that color, and coverage is independent of the order.
TEST_F(Layers, WeightedIsExactForOneColorAndForCoverage) {
  const Staircase same(true), many;
  const std::vector<vec4> picture = linear(same.stack.scene, kColumns, "weighted");
  for (uint32_t i = 0; i < picture.size(); ++i)
    ASSERT_LE(apart(picture[i], same.expected(i % kColumns, i / kColumns)), kStep) << i;
  const std::vector<vec4> colors = linear(many.stack.scene, kColumns, "weighted");
  for (uint32_t i = 0; i < colors.size(); ++i)
    ASSERT_NEAR(colors[i].a, many.expected(i % kColumns, i / kColumns).a, kStep) << i;
}

// The published weight for two layers: equation 7 of McGuire and Bavoil 2013, with distances from the camera at z = 4.
TEST_F(Layers, WeightedWeighsAsItsPaperSays) {
  Stack stack;
  const Layer near{1, {1, 0, 0, 0.5f}}, far{-1, {0, 1, 0, 0.75f}};
  for (const Layer& layer : {near, far}) stack.square(stack.glass(layer.color), {0, 0, layer.z}, {1.1f, 1.1f});
  const auto weight = [](const Layer& layer) {
    const double depth = 4 - layer.z;
    return layer.color.a * std::clamp(10 / (1e-5 + std::pow(depth / 5, 2) + std::pow(depth / 200, 6)), 1e-2, 3e3);
  };
  const double a = near.color.a * weight(near), b = far.color.a * weight(far);
  const double coverage = 1 - (1 - near.color.a) * (1 - far.color.a);
  const dvec4 expected(a / (a + b) * coverage, b / (a + b) * coverage, 0, coverage);
  for (const vec4& pixel : linear(stack.scene, 4, "weighted")) EXPECT_LE(apart(pixel, expected), kStep);
}

TEST_F(Layers, NoneLeavesThemOut) {
  const Staircase stairs;
  const std::vector<vec4> picture = linear(stairs.stack.scene, kColumns, "none");
  EXPECT_EQ(picture.front(), vec4(0));
  EXPECT_LE(apart(picture.back(), dvec4(stairs.wall, 1)), kStep);
}

// --- intersecting triangles -----------------------------------------------------------------------------------------

// The point where the center of a pixel meets a triangle; `margin` is its distance to the edges, less than 0 outside.
struct Meeting {
  double z, margin;
};
Meeting meet(const ColoredTriangle& t, glm::dvec2 p) {
  const auto cross = [](glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; };
  glm::dvec2 c[3];
  for (int i = 0; i < 3; ++i) c[i] = glm::dvec2(t.corners[i]);
  const double area = cross(c[1] - c[0], c[2] - c[0]);
  double weights[3], z = 0;
  for (int i = 0; i < 3; ++i) {
    weights[i] = cross(c[(i + 1) % 3] - p, c[(i + 2) % 3] - p) / area;
    z += weights[i] * double{t.corners[i].z};
  }
  return {z, std::min({weights[0], weights[1], weights[2]})};
}

TEST_F(Layers, RandomTrianglesThroughEachOther) {
  constexpr uint32_t kSize = 64;
  shared::Random random(11);
  std::vector<ColoredTriangle> triangles(60);
  for (ColoredTriangle& t : triangles) {
    for (vec3& corner : t.corners)
      corner = {random.uniform(-1.2f, 1.2f), random.uniform(-1.2f, 1.2f), random.uniform(-1.5f, 1.5f)};
    t.color = randomColor(random);
  }
  const std::vector<vec4> picture = linear(sceneOf(triangles), kSize, "exact");
  size_t compared = 0, most = 0;
  for (uint32_t i = 0; i < picture.size(); ++i) {
    const glm::dvec2 p((i % kSize + 0.5) / kSize * 2 - 1, 1 - (i / kSize + 0.5) / kSize * 2);
    std::vector<Layer> layers;
    bool clear = true;
    for (const ColoredTriangle& t : triangles) {
      const Meeting m = meet(t, p);
      clear = clear && std::abs(m.margin) > 2e-3;
      for (const Layer& other : layers) clear = clear && (m.margin < 0 || std::abs(other.z - m.z) > 1e-4);
      if (m.margin > 0) layers.push_back({m.z, t.color});
    }
    if (!clear) continue;
    ++compared;
    most = std::max(most, layers.size());
    ASSERT_LE(apart(picture[i], blendInOrder(layers, dvec4(0))), kStep) << i;
  }
  EXPECT_GT(compared, picture.size() / 2);
  EXPECT_GT(most, 12u);
}

// --- very many layers -----------------------------------------------------------------------------------------------

// Each layer covers the picture, in no particular order. There are more fragments than the initial capacity, and lists
// that need ten steps to sort. Each jittered frame of supersampling sees the same.
TEST_F(Layers, TenThousandAreSortedToo) {
  constexpr uint32_t kSize = 4;
  const uint32_t count = latelight::test::rounds(10'000u, 2'000u);
  shared::Random random(5);
  std::vector<ColoredTriangle> triangles(count);
  std::vector<Layer> layers;
  for (uint32_t i = 0; i < count; ++i) {
    const float z = -1.5f + 3.0f * static_cast<float>((i * 7919) % count) / static_cast<float>(count);
    vec4 color = randomColor(random);
    color.a = random.uniform(0.0002f, 0.001f);
    triangles[i] = {{{-4, -4, z}, {12, -4, z}, {-4, 12, z}}, color};
    layers.push_back({z, color});
  }
  // Colours that drift with depth, so that a wrong order shows.
  for (uint32_t i = 0; i < count; ++i) {
    const float t = (static_cast<float>(layers[i].z) + 1.5f) / 3;
    triangles[i].color = layers[i].color = vec4(t, 1 - t, layers[i].color.b, layers[i].color.a);
  }
  const dvec4 expected = blendInOrder(layers, dvec4(0));
  const scene::Scene scene = sceneOf(triangles);
  for (uint32_t superSampling : {1u, 2u})
    for (const vec4& pixel : linear(scene, kSize, "exact", superSampling)) ASSERT_LE(apart(pixel, expected), kStep);
}

// --- equal depths, and coverage -------------------------------------------------------------------------------------

// At equal depth, a surface that is drawn later lies over one that is drawn earlier: by material, in the scene's order.
TEST_F(Layers, TiesAreSettledByTheOrderOfDraws) {
  Stack stack;
  std::vector<Layer> layers;
  shared::Random random(9);
  for (int i = 0; i < 40; ++i) {
    layers.push_back({0, randomColor(random)});
    stack.square(stack.glass(layers.back().color), {0, 0, 0}, {1.1f, 1.1f});
  }
  const dvec4 expected = blendInOrder(layers, dvec4(0));
  const std::vector<vec4> picture = linear(stack.scene, 16, "exact");
  for (const vec4& pixel : picture) ASSERT_LE(apart(pixel, expected), kStep);
  EXPECT_EQ(linear(stack.scene, 16, "exact"), picture);
}

// Squares of 2.4 km, which `hardware` draws as fans of triangles (kVastFan), among small ones: by depth and, at equal
// depth, in the order of draws.
TEST_F(Layers, VastSurfacesBlendLikeSmallOnes) {
  Stack stack;
  std::vector<Layer> layers;
  shared::Random random(10);
  for (int i = 0; i < 12; ++i) {
    layers.push_back({0.5 * (i / 4), randomColor(random)});
    const float half = i % 2 == 0 ? 1200 : 1.1f;
    stack.square(stack.glass(layers.back().color), {0, 0, layers.back().z}, {half, half});
  }
  const vec3 ground(0.3f, 0.2f, 0.1f);
  stack.square(stack.solid(ground), {0, 0, -1}, {1200, 1200});
  const dvec4 expected = blendInOrder(layers, dvec4(ground, 1));
  for (const vec4& pixel : linear(stack.scene, 16, "exact")) ASSERT_LE(apart(pixel, expected), kStep);
  const std::vector<vec4> weighted = linear(stack.scene, 16, "weighted");
  for (const vec4& pixel : weighted) ASSERT_EQ(pixel, weighted.front());
  const Layer near{1, {1, 0, 0, 0.5f}}, far{-1, {0, 1, 0, 0.75f}};
  Stack apartStack;
  for (const Layer& layer : {near, far})
    apartStack.square(apartStack.glass(layer.color), {0, 0, layer.z}, {1200, 1200});
  for (const vec4& pixel : linear(apartStack.scene, 16, "sorted"))
    ASSERT_LE(apart(pixel, blendInOrder({near, far}, dvec4(0))), kStep);
}

// On an opaque surface of equal depth it is visible: a decal.
TEST_F(Layers, DecalsShow) {
  Stack stack;
  stack.square(stack.glass({1, 0, 0, 0.5f}), {0, 0, 0}, {1.1f, 1.1f});
  stack.square(stack.solid({0, 0, 1}), {0, 0, 0}, {1.1f, 1.1f});
  for (const char* method : {"exact", "sorted", "weighted"})
    for (const vec4& pixel : linear(stack.scene, 4, method)) EXPECT_LE(apart(pixel, {0.5, 0, 0.5, 1}), kStep) << method;
}

// PNG's straight alpha: the color of the glass with its coverage, or blended over the requested background.
TEST_F(Layers, GlassOverNothingHasItsOwnColorAndCoverage) {
  Stack stack;
  stack.square(stack.glass({0.25f, 0.5f, 0.75f, 0.4f}), {0, 0, 0}, {1.1f, 1.1f});
  Settings settings = settingsOf(4, 4);
  settings.display = true;
  settings.tonemap = Tonemap::None;
  const auto code = [](double x) { return 255 * shared::srgbFromLinear(static_cast<float>(x)); };
  for (const char* method : {"exact", "sorted", "weighted"}) {
    SCOPED_TRACE(method);
    settings.transparency = choiceNamed<TransparencyMethod>(method).value();
    settings.background.kind = Background::Transparent;
    const auto clear = renderOne(device(), stack.scene, frontCamera(), settings).display;
    const double straight[] = {code(0.25), code(0.5), code(0.75), 0.4 * 255};
    for (size_t i = 0; i < clear.size(); ++i) ASSERT_NEAR(clear[i], straight[i % 4], 1) << i;
    settings.background.kind = Background::Color;
    settings.background.color = {1, 0, 0};
    const auto over = renderOne(device(), stack.scene, frontCamera(), settings).display;
    const double mixed[] = {code(0.25 * 0.4 + 0.6), code(0.5 * 0.4), code(0.75 * 0.4), 255};
    for (size_t i = 0; i < over.size(); ++i) ASSERT_NEAR(over[i], mixed[i % 4], 1) << i;
  }
}

// The alpha of texture, factor and vertex color are multiplied; back faces are visible if the material is double-sided.
TEST_F(Layers, AlphaIsTextureTimesFactorTimesVertexColor) {
  Stack stack;
  stack.scene.meshes.front() = squareMesh(true);
  for (shared::VertexExtra& extra : stack.scene.meshes.front().extras) extra.color = {1, 1, 1, 0.5f};
  const uint32_t material = stack.glass({1, 1, 1, 0.8f});
  stack.scene.textures.push_back(
      textureOf(2, 2, true, {{255, 255, 255, 255}, {255, 255, 255, 0}, {255, 255, 255, 128}, {255, 255, 255, 51}}));
  setTexture(stack.scene.materials[material], shared::kTextureBaseColor, 0, kNearest);
  stack.square(material, {0, 0, 0}, {1, 1});
  const std::vector<vec4> picture = linear(stack.scene, 2, "exact");
  const double alphas[] = {1, 0, 128.0 / 255, 0.2};
  for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(picture[i].a, alphas[i] * 0.8 * 0.5, kStep / 4) << i;

  Stack turned;
  const uint32_t oneSided = turned.glass({1, 1, 1, 0.5f}), twoSided = turned.glass({1, 1, 1, 0.5f});
  turned.scene.materials[twoSided].data.flags |= shared::kMaterialDoubleSided;
  for (uint32_t m : {oneSided, twoSided})
    turned.builder.addInstance("back", 0, 0, m, glm::rotate(glm::mat4(1), 3.14159265f, vec3(0, 1, 0)));
  for (const char* method : {"exact", "sorted", "weighted"})
    for (const vec4& pixel : linear(turned.scene, 2, method)) EXPECT_NEAR(pixel.a, 0.5, kStep) << method;
}

// --- data outputs ---------------------------------------------------------------------------------------------------

TEST_F(Layers, DataShowOpaqueSurfacesOrAny) {
  Stack stack;
  const uint32_t holes = stack.glass({1, 1, 1, 0.01f});
  stack.scene.textures.push_back(
      textureOf(2, 2, true, {{255, 255, 255, 255}, {255, 255, 255, 0}, {255, 255, 255, 255}, {255, 255, 255, 255}}));
  setTexture(stack.scene.materials[holes], shared::kTextureBaseColor, 0, kNearest);
  stack.square(holes, {0, 0, 1}, {1, 1});
  stack.square(stack.solid({0, 0, 1}), {0, 0.5f, 0}, {1, 0.5f});  // the upper half
  const uint32_t glass = stack.scene.instances[0].id, wall = stack.scene.instances[1].id;
  Settings settings = settingsOf(2, 2, {Aov::Id, Aov::Depth});
  const auto frame = renderOne(device(), stack.scene, frontCamera(), settings);
  EXPECT_EQ(imageOf(frame, Aov::Id).ids, (std::vector<uint32_t>{wall, wall, 0, 0}));
  settings.dataSurfaces = DataSurfaces::Any;
  const auto any = renderOne(device(), stack.scene, frontCamera(), settings);
  EXPECT_EQ(imageOf(any, Aov::Id).ids, (std::vector<uint32_t>{glass, wall, glass, glass}));
  EXPECT_NEAR(imageOf(any, Aov::Depth).values[0], 3, 1e-5);
  EXPECT_NEAR(imageOf(any, Aov::Depth).values[1], 4, 1e-5);
}

}  // namespace
}  // namespace latelight::render::test
