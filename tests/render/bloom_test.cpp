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
  // The mean of the image over an area.
  dvec3 mean(double left, double right, double top, double bottom) const {
    dvec3 total(0);
    for (int y = int(std::floor(top)); y < bottom; ++y)
      for (int x = int(std::floor(left)); x < right; ++x)
        total += mirrored(x, y) * ((std::min(right, x + 1.0) - std::max(left, double(x))) *
                                   (std::min(bottom, y + 1.0) - std::max(top, double(y))));
    return total / ((right - left) * (bottom - top));
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

// Downsamples with 13 taps in five groups (Jimenez 2014, slide 153). Each is the mean over the area of one new texel.
Grid halved(const Grid& from, bool damp) {
  Grid to((from.width + 1) / 2, (from.height + 1) / 2);
  const double wide = double(from.width) / to.width, high = double(from.height) / to.height;
  constexpr std::array<std::array<double, 3>, 5> kGroups{
      {{0, 0, 0.5}, {-1, -1, 0.125}, {1, -1, 0.125}, {-1, 1, 0.125}, {1, 1, 0.125}}};
  for (int y = 0; y < to.height; ++y)
    for (int x = 0; x < to.width; ++x)
      for (const auto& [gx, gy, share] : kGroups) {
        dvec3 sum(0);
        double weights = 0;
        for (int i = 0; i < 4; ++i) {
          const double left = x + 0.5 * gx - (i & 1 ? 0 : 1) + 0.5, top = y + 0.5 * gy - (i & 2 ? 0 : 1) + 0.5;
          const dvec3 tap = from.mean(left * wide, (left + 1) * wide, top * high, (top + 1) * high);
          const double weight = damp ? 1 / (1 + luminanceOf(tap)) : 1;
          sum += tap * weight, weights += weight;
        }
        to.at(x, y) += sum * (share / weights);
      }
  return to;
}

// Splits a texel of the finer level, in texels of the coarser one, where the linear interpolation has its corners: at
// the centers of texels. Returns the centers of the parts with their shares of the texel.
std::vector<std::pair<double, double>> linearParts(int texel, int fine, int coarse) {
  const double ratio = double(coarse) / fine, from = texel * ratio, to = from + ratio;
  std::vector<std::pair<double, double>> parts;
  for (double start = from; start < to - 1e-9;) {
    double end = std::floor(start + 0.5 + 1e-9) + 0.5;
    end = std::min(end, to);
    parts.emplace_back((start + end) / 2, (end - start) / ratio);
    start = end;
  }
  return parts;
}

// The mean of the interpolated level over a texel of the finer level, after a tent filter of 3x3 texels.
dvec3 tent(const Grid& coarse, const Grid& fine, int x, int y) {
  dvec3 sum(0);
  for (const auto& [u, wide] : linearParts(x, fine.width, coarse.width))
    for (const auto& [v, high] : linearParts(y, fine.height, coarse.height))
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i)
          sum += coarse.sampled(u + i, v + j) * (wide * high * (2.0 - std::abs(i)) * (2.0 - std::abs(j)) / 16);
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
        joined.at(x, y) = glm::mix(joined.at(x, y), tent(glow, joined, x, y), double{p.radius});
    glow = std::move(joined);
  }
  Grid result = picture;
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x)
      result.at(x, y) += double{p.strength} * (tent(glow, result, x, y) - bright.at(x, y));
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
  for (auto [width, height] :
       {std::pair{1, 1}, {2, 1}, {3, 5}, {9, 6}, {16, 16}, {17, 33}, {37, 23}, {44, 28}, {61, 95}}) {
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
  for (auto [width, height] : {std::pair{64, 64}, {128, 32}, {61, 47}}) {
    SCOPED_TRACE(fmt::format("{}x{}", width, height));
    shared::Random random(3);
    Grid picture(width, height);
    for (dvec3& c : picture.texels) c = dvec3(random.color());
    picture.at(width / 2, height / 2) = dvec3(5000, 3000, 100);
    picture.at(1, 2) = dvec3(100);
    const BloomParameters parameters{.strength = 1, .radius = 0.8f, .fireflies = kBloomKeep};
    const dvec3 before = picture.sum(), after = bloomedGrid(picture, parameters).sum();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(after[c] / before[c], 1, 1e-5);
    // Damping removes light from isolated bright pixels and adds none elsewhere.
    BloomParameters damped = parameters;
    damped.fireflies = kBloomDamp;
    EXPECT_LT(bloomedGrid(picture, damped).sum().x, 0.5 * before.x);
  }
}

// Levels with odd sides conserve light too, wherever it is: 270 is followed by 135, 68, 34, 17, 9, 5, 3, 2 and 1.
TEST_F(BloomTest, LightOfASpotIsConservedAtAnySizeAndPosition) {
  double worst = 0;
  for (auto [width, height] : {std::pair{480, 270}, {129, 65}, {31, 31}, {17, 3}, {5, 1}, {3, 3}, {2, 7}})
    for (auto [u, v] : {std::pair{0.0, 0.0}, {0.5, 0.5}, {1.0, 1.0}, {1.0, 0.0}, {0.0, 0.9}, {0.97, 0.6}})
      for (float radius : {0.5f, 1.0f}) {
        Grid picture(width, height);
        picture.at(int(u * (width - 1)), int(v * (height - 1))) = dvec3(1000, 10, 1);
        const Grid glow = bloomedGrid(picture, {.strength = 1, .radius = radius, .fireflies = kBloomKeep});
        const double error = std::abs(glow.sum().x / 1000 - 1);
        worst = std::max(worst, error);
        EXPECT_LT(error, 2e-6) << width << 'x' << height << " at " << u << ' ' << v << ", radius " << radius;
        if (radius < 1) continue;
        // All light passes through the single texel of the last level. Where the spot was, floats round at 1000.
        const double mean = 1000.0 / (width * height);
        for (const dvec3& c : glow.texels) ASSERT_NEAR(c.x, mean, 1e-4 + 1e-5 * mean);
      }
  fmt::print("bloom: the light of a spot changes by at most {:.1e}\n", worst);
}

TEST_F(BloomTest, AUniformImageStaysUnchanged) {
  const dvec3 color(0.25, 0.5, 4);
  double worst = 0;
  for (auto [width, height] : {std::pair{64, 64}, {128, 32}, {61, 47}, {480, 270}, {129, 65}, {3, 1}})
    for (uint32_t fireflies : {kBloomDamp, kBloomKeep}) {
      Grid even(width, height);
      for (dvec3& c : even.texels) c = color;
      for (const dvec3& c : bloomedGrid(even, {.strength = 1, .radius = 0.8f, .fireflies = fireflies}).texels)
        for (int i = 0; i < 3; ++i) worst = std::max(worst, std::abs(c[i] / color[i] - 1));
    }
  EXPECT_LT(worst, 1e-6);
  fmt::print("bloom: a uniform image changes by at most {:.1e}\n", worst);
}

TEST_F(BloomTest, AGlowIsSymmetricAndFallsOff) {
  for (int size : {64, 61, 100}) {
    SCOPED_TRACE(size);
    const int low = (size - 1) / 2, high = size / 2;
    Grid picture(size, size);
    for (int x : {low, high})
      for (int y : {low, high}) picture.at(x, y) = dvec3(1000);
    const BloomParameters parameters{.strength = 0.5f, .radius = 0.7f, .fireflies = kBloomKeep};
    Grid glow = bloomedGrid(picture, parameters);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const double value = glow.at(x, y).x, tolerance = 1e-6 + 1e-5 * value;
        ASSERT_NEAR(glow.at(size - 1 - x, y).x, value, tolerance) << x << ' ' << y;
        ASSERT_NEAR(glow.at(x, size - 1 - y).x, value, tolerance) << x << ' ' << y;
        ASSERT_NEAR(glow.at(y, x).x, value, tolerance) << x << ' ' << y;
      }
    for (int x = high; x + 1 < size; ++x) EXPECT_GE(glow.at(x, high).x * 1.001, glow.at(x + 1, high).x) << x;
  }
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
