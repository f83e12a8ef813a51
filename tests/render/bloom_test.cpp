// Bloom: its downsampling and upsampling chain against the CPU in double precision, energy conservation, and a uniform
// glow.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "render/base/readback.h"
#include "render/post/bloom/bloom.h"
#include "render/support.h"
#include "shared/color.h"
#include "shared/random.h"

namespace latelight::render::test {
namespace {

using glm::dvec3;
using glm::vec4;

struct Grid {
  int width, height;
  std::vector<dvec3> texels;
  Grid(int w, int h) : width(w), height(h), texels(size_t(w) * size_t(h)) {}
  dvec3& at(int x, int y) { return texels[size_t(y) * size_t(width) + size_t(x)]; }
  // Reads the image extended by its mirror images.
  dvec3 mirrored(int x, int y) const {
    const auto fold = [](int i, int n) {
      i = ((i % (2 * n)) + 2 * n) % (2 * n);
      return i < n ? i : 2 * n - 1 - i;
    };
    return texels[size_t(fold(y, height)) * size_t(width) + size_t(fold(x, width))];
  }
  // Bilinear sampling; texel centers are at .5.
  dvec3 sampled(double x, double y) const {
    const double fx = std::floor(x - 0.5), fy = std::floor(y - 0.5), u = x - 0.5 - fx, v = y - 0.5 - fy;
    const int i = int(fx), j = int(fy);
    return (mirrored(i, j) * (1 - u) + mirrored(i + 1, j) * u) * (1 - v) +
           (mirrored(i, j + 1) * (1 - u) + mirrored(i + 1, j + 1) * u) * v;
  }
  dvec3 sum() const {
    dvec3 total(0);
    for (const dvec3& t : texels) total += t;
    return total;
  }
};

double luminanceOf(dvec3 c) {
  return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
}

// Downsamples with 13 bilinear taps in five groups (Jimenez 2014, slide 153).
Grid halved(const Grid& from, bool damp) {
  Grid to((from.width + 1) / 2, (from.height + 1) / 2);
  constexpr std::array<std::array<double, 3>, 5> kGroups{
      {{0, 0, 0.5}, {-1, -1, 0.125}, {1, -1, 0.125}, {-1, 1, 0.125}, {1, 1, 0.125}}};
  for (int y = 0; y < to.height; ++y)
    for (int x = 0; x < to.width; ++x)
      for (const auto& [gx, gy, share] : kGroups) {
        dvec3 sum(0);
        double weights = 0;
        for (int i = 0; i < 4; ++i) {
          const dvec3 tap = from.sampled(2 * x + 1 + gx + (i & 1 ? 1 : -1), 2 * y + 1 + gy + (i & 2 ? 1 : -1));
          const double weight = damp ? 1 / (1 + luminanceOf(tap)) : 1;
          sum += tap * weight, weights += weight;
        }
        to.at(x, y) += sum * (share / weights);
      }
  return to;
}

dvec3 tent(const Grid& coarse, int x, int y) {
  dvec3 sum(0);
  for (int j = -1; j <= 1; ++j)
    for (int i = -1; i <= 1; ++i)
      sum += coarse.sampled((x + 0.5) / 2 + i, (y + 0.5) / 2 + j) * ((2.0 - std::abs(i)) * (2.0 - std::abs(j)) / 16);
  return sum;
}

Grid reference(const Grid& picture, const BloomParameters& p) {
  Grid bright = picture;
  for (dvec3& c : bright.texels)
    if (p.threshold > 0) c *= std::max(luminanceOf(c) - double{p.threshold}, 0.0) / std::max(luminanceOf(c), 1e-20);
  std::vector<Grid> levels{halved(bright, p.fireflies == kBloomDamp)};
  while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(halved(levels.back(), false));
  Grid glow = levels.back();
  for (size_t i = levels.size() - 1; i-- > 0;) {
    Grid joined = levels[i];
    for (int y = 0; y < joined.height; ++y)
      for (int x = 0; x < joined.width; ++x)
        joined.at(x, y) = glm::mix(joined.at(x, y), tent(glow, x, y), double{p.radius});
    glow = std::move(joined);
  }
  Grid result = picture;
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x) result.at(x, y) += double{p.strength} * (tent(glow, x, y) - bright.at(x, y));
  return result;
}

class BloomTest : public RenderTest {
 protected:
  // Applies bloom to images of the same size.
  static std::vector<std::vector<vec4>> bloomed(const std::vector<std::vector<vec4>>& pictures, uint32_t width,
                                                uint32_t height, const BloomParameters& parameters) {
    std::vector<std::vector<vec4>> results;
    graph::Executor executor(device());
    for (const std::vector<vec4>& picture : pictures) {
      const vk::Image image(device(), {.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                                       .width = width,
                                       .height = height,
                                       .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                                       .name = "picture"});
      vk::Uploader(device()).upload(image, std::as_bytes(std::span(picture)));
      graph::Graph graph;
      const graph::ImageId imported = graph.import(image, graph::Use::SampledCompute);
      const graph::BufferId values = addReadback(graph, addBloom({device(), graph}, imported, parameters));
      executor.run(graph, graph.compile());
      const vec4* from = executor.buffer(values).as<vec4>();
      results.emplace_back(from, from + picture.size());
    }
    return results;
  }

  static Grid bloomedGrid(const Grid& picture, const BloomParameters& parameters) {
    std::vector<vec4> texels;
    for (const dvec3& c : picture.texels) texels.emplace_back(glm::vec3(c), 1);
    const auto result = bloomed({texels}, uint32_t(picture.width), uint32_t(picture.height), parameters).front();
    Grid grid(picture.width, picture.height);
    for (size_t i = 0; i < result.size(); ++i) {
      grid.texels[i] = dvec3(result[i]);
      EXPECT_EQ(result[i].a, 1.0f);
    }
    return grid;
  }
};

TEST_F(BloomTest, TheChainIsItsReference) {
  double worst = 0;
  for (auto [width, height] : {std::pair{1, 1}, {2, 1}, {3, 5}, {16, 16}, {37, 23}, {44, 28}}) {
    shared::Random random(uint64_t(100 * width + height));
    Grid picture(width, height);
    for (dvec3& c : picture.texels) {
      c = dvec3(random.color());
      if (random.uniform() < 0.05f) c *= 300;  // light sources
    }
    for (uint32_t fireflies : {kBloomDamp, kBloomKeep})
      for (float threshold : {0.0f, 1.0f}) {
        SCOPED_TRACE(fmt::format("{}x{}, fireflies {}, threshold {}", width, height, fireflies, threshold));
        const BloomParameters parameters{
            .strength = 0.4f, .radius = 0.7f, .threshold = threshold, .fireflies = fireflies};
        const Grid expected = reference(picture, parameters), found = bloomedGrid(picture, parameters);
        for (size_t i = 0; i < expected.texels.size(); ++i)
          for (int c = 0; c < 3; ++c) {
            const double error = std::abs(found.texels[i][c] - expected.texels[i][c]) / (expected.texels[i][c] + 0.5);
            worst = std::max(worst, error);
            ASSERT_LT(error, 1e-5) << i;
          }
      }
  }
  fmt::print("bloom: at most {:.5f} of a value from its reference\n", worst);
}

TEST_F(BloomTest, LightIsConserved) {
  for (auto [width, height, tolerance] : {std::tuple{64, 64, 1e-5}, {128, 32, 1e-5}, {61, 47, 0.05}}) {
    SCOPED_TRACE(fmt::format("{}x{}", width, height));
    shared::Random random(3);
    Grid picture(width, height);
    for (dvec3& c : picture.texels) c = dvec3(random.color());
    picture.at(width / 2, height / 2) = dvec3(5000, 3000, 100);
    picture.at(1, 2) = dvec3(100);
    const BloomParameters parameters{.strength = 1, .radius = 0.8f, .fireflies = kBloomKeep};
    const dvec3 before = picture.sum(), after = bloomedGrid(picture, parameters).sum();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(after[c] / before[c], 1, tolerance);
    // Damping removes light from isolated bright pixels and adds none elsewhere.
    BloomParameters damped = parameters;
    damped.fireflies = kBloomDamp;
    EXPECT_LT(bloomedGrid(picture, damped).sum().x, 0.5 * before.x);
    // A uniform image stays unchanged, also at its edges.
    Grid even(width, height);
    for (dvec3& c : even.texels) c = dvec3(0.25, 0.5, 4);
    for (const dvec3& c : bloomedGrid(even, damped).texels) ASSERT_LT(glm::length(c - dvec3(0.25, 0.5, 4)), 4e-3);
  }
}

TEST_F(BloomTest, AGlowIsSymmetricAndFallsOff) {
  constexpr int kSize = 64, kMiddle = kSize / 2;
  Grid picture(kSize, kSize);
  for (int i = 0; i < 4; ++i) picture.at(kMiddle - 1 + (i & 1), kMiddle - 1 + (i >> 1)) = dvec3(1000);
  const BloomParameters parameters{.strength = 0.5f, .radius = 0.7f, .fireflies = kBloomKeep};
  Grid glow = bloomedGrid(picture, parameters);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const double value = glow.at(x, y).x, tolerance = 1e-6 + 1e-5 * value;
      ASSERT_NEAR(glow.at(kSize - 1 - x, y).x, value, tolerance) << x << ' ' << y;
      ASSERT_NEAR(glow.at(x, kSize - 1 - y).x, value, tolerance) << x << ' ' << y;
      ASSERT_NEAR(glow.at(y, x).x, value, tolerance) << x << ' ' << y;
    }
  for (int x = kMiddle; x + 1 < kSize; ++x) EXPECT_GE(glow.at(x, kMiddle).x * 1.001, glow.at(x + 1, kMiddle).x) << x;
}

// The alpha of a glow over the background equals the glow's brightness; the object itself stays opaque.
TEST_F(BloomTest, GlowOverTheBackgroundHasItsOwnOpacity) {
  constexpr uint32_t kSize = 32;
  std::vector<vec4> picture(kSize * kSize, vec4(0)), empty = picture;
  for (uint32_t y = 12; y < 20; ++y)
    for (uint32_t x = 12; x < 20; ++x) picture[y * kSize + x] = vec4(8, 4, 1, 1);
  const auto results =
      bloomed({picture, empty}, kSize, kSize, {.strength = 0.3f, .radius = 0.7f, .fireflies = kBloomKeep});
  for (size_t i = 0; i < picture.size(); ++i) {
    const vec4 c = results[0][i];
    if (picture[i].a == 1)
      EXPECT_EQ(c.a, 1.0f);
    else
      EXPECT_NEAR(c.a, std::min(std::max(c.r, std::max(c.g, c.b)), 1.0f), 1e-6f);
    EXPECT_EQ(results[1][i], vec4(0));
  }
  EXPECT_GT(results[0][10 * kSize + 16].a, 0.05f);
}

}  // namespace
}  // namespace latelight::render::test
