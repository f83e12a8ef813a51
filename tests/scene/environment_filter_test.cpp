// Prefiltering of an environment image compared with closed forms and with sums over every pixel.
#include "scene/environment/filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "long_tests.h"
#include "scene/environment/picture.h"
#include "scene/environment_support.h"
#include "scene/scene.h"

namespace latelight::scene {
namespace {

using glm::vec3;

float relativeError(const vec3& found, const vec3& expected) {
  return glm::length(found - expected) / glm::length(expected);
}

// The weight of light at cosine c to a lobe's axis, directly from GGX's distribution (half vector at half the angle),
// unlike the code.
double lobe(double c, double alpha) {
  if (c <= 0.0) return 0.0;
  const double nh = std::cos(std::acos(std::min(c, 1.0)) / 2.0), a2 = alpha * alpha;
  const double d = nh * nh * (a2 - 1.0) + 1.0;
  return a2 / (d * d) * c / (1.0 + a2 * c);
}

// The mean of c under the lobe, by which it scales a linear gradient.
double linearShare(double alpha) {
  double weighted = 0.0, whole = 0.0;
  constexpr int kSteps = 200000;
  for (int i = 0; i < kSteps; ++i) {
    // Steps in the square root of the angle's fraction, denser near the lobe's axis.
    const double t = (i + 0.5) / kSteps, angle = t * t * std::numbers::pi / 2.0;
    const double weight = lobe(std::cos(angle), alpha) * std::sin(angle) * t;
    weighted += weight * std::cos(angle);
    whole += weight;
  }
  return weighted / whole;
}

TEST(EnvironmentFilter, LevelsAreOneMipChain) {
  for (const uint32_t height : {1u, 16u, 257u, 512u}) {
    const Environment e = filterEnvironment(makePicture(height, [](const vec3&) { return vec3(1); }));
    ASSERT_GE(e.specular.size(), 5u);
    for (size_t i = 0; i < e.specular.size(); ++i) {
      EXPECT_EQ(e.specular[i].width, e.specular[0].width >> i);
      EXPECT_EQ(e.specular[i].height, e.specular[i].width);
      EXPECT_EQ(e.specular[i].texels.size(), size_t{8} * e.specular[i].width * e.specular[i].width);
    }
    EXPECT_GE(e.specular.back().width, 16u);
    EXPECT_EQ(e.radiance.width, 2 * height);
    EXPECT_EQ(e.diffuse.width, e.diffuse.height);
  }
}

TEST(EnvironmentFilter, ConstantStaysConstant) {
  const vec3 value(0.25f, 1.5f, 7.0f);
  Environment e = filterEnvironment(makePicture(64, [&](const vec3&) { return value; }));
  e.specular.push_back(e.diffuse);
  e.specular.push_back(e.radiance);
  for (const RadianceMap& map : e.specular) {
    for (size_t y = 0; y < map.height; ++y) {
      for (size_t x = 0; x < map.width; ++x) {
        const vec3 found = texel(map, x, y);
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(found[c], value[c], value[c] / 2048.0f) << map.width << ": " << x << ", " << y;
        ASSERT_EQ(map.at(x, y).w, 1.0f) << "alpha is 1";
      }
    }
  }
}

TEST(EnvironmentFilter, GradientHasItsClosedForm) {
  const vec3 axis = glm::normalize(vec3(0.3f, -0.7f, 0.5f));
  const Environment e = filterEnvironment(
      makePicture(256, [&](const vec3& d) { return vec3(1.0f) + vec3(0.2f, 0.5f, 0.9f) * glm::dot(d, axis); }));
  const auto expect = [&](const RadianceMap& map, double share, const std::string& what) {
    // The error of bilinear filtering decreases with the square of the size.
    const float allowed = 0.003f + 4.0f / static_cast<float>(map.width * map.width);
    for (int i = 0; i < 500; ++i) {
      const vec3 d = spiral(i, 500);
      const vec3 exact = vec3(1.0f) + vec3(0.2f, 0.5f, 0.9f) * (glm::dot(d, axis) * static_cast<float>(share));
      EXPECT_LE(relativeError(lookUp(map, d), exact), allowed) << what << ", direction " << i;
    }
  };
  expect(e.diffuse, 2.0 / 3.0, "irradiance / pi of 1 + k.d is 1 + 2/3 k.n");
  expect(e.specular[0], 1.0, "the mirror");
  for (size_t level = 1; level < e.specular.size(); ++level) {
    const double roughness = kSpecularRoughness[level];
    expect(e.specular[level], linearShare(roughness * roughness), "level " + std::to_string(level));
  }
}

// A disk of uniform radiance: irradiance is L pi sin^2(radius) cos if all of it is above the horizon.
TEST(EnvironmentFilter, DiscLightsBySolidAngleAndCosine) {
  const vec3 towards = glm::normalize(vec3(-0.5f, 0.4f, 0.6f));
  const double radius = 0.05, radiance = 2000.0;
  const FloatImage picture = makePicture(512, [&](const vec3& d) {
    return vec3(glm::length(d - towards) < 2.0 * std::sin(radius / 2.0) ? static_cast<float>(radiance) : 0.0f);
  });
  const Environment e = filterEnvironment(picture);
  for (int i = 0; i < 1000; ++i) {
    const vec3 n = spiral(i, 1000);
    const double cosine = glm::dot(n, towards);
    const float found = lookUp(e.diffuse, n).x;
    // The disc's edge in pixels is jagged: 1 % of its area.
    if (cosine > 0.1) {
      const double exact = radiance * std::sin(radius) * std::sin(radius) * cosine;
      EXPECT_NEAR(found, exact, 0.015 * exact) << "cosine " << cosine;
    }
    if (cosine < -0.1) {
      EXPECT_EQ(found, 0.0f) << "cosine " << cosine;
    }
  }
}

TEST(EnvironmentFilter, EveryLevelKeepsTheEnergy) {
  const vec3 sun = glm::normalize(vec3(0.2f, 0.7f, 0.1f));
  const FloatImage picture = makePicture(256, [&](const vec3& d) {
    return vec3(0.5f + 0.4f * d.z) + (glm::dot(d, sun) > 0.999f ? vec3(900, 700, 500) : vec3(0));
  });
  const Environment e = filterEnvironment(picture);
  constexpr int kCount = 100000;
  const auto mean = [&](const RadianceMap& map) {
    glm::dvec3 sum(0);
    for (int i = 0; i < kCount; ++i) sum += lookUp(map, spiral(i, kCount));
    return vec3(sum / static_cast<double>(kCount));
  };
  glm::dvec3 exact(0);
  double whole = 0;
  for (uint32_t y = 0; y < picture.height; ++y) {
    const double weight = std::sin((y + 0.5) / picture.height * std::numbers::pi);
    for (uint32_t x = 0; x < picture.width; ++x) {
      const float* p = picture.at(x, y);
      exact += glm::dvec3(p[0], p[1], p[2]) * weight;
      whole += weight;
    }
  }
  for (const RadianceMap& map : e.specular) EXPECT_LE(relativeError(mean(map), exact / whole), 0.01f) << map.width;
  EXPECT_LE(relativeError(mean(e.diffuse), exact / whole), 0.01f);
}

// A sun of one pixel, the most difficult image, compared with the sum over every pixel.
class SunOfOnePixel : public testing::TestWithParam<float> {};

TEST_P(SunOfOnePixel, LightsLobesAsTheSumOverPixels) {
  FloatImage picture = makePicture(128, [](const vec3& d) {
    return vec3(0.3f, 0.5f, 0.9f) * (1.2f + d.z) +
           (d.z < 0.0f ? vec3(0.3f, 0.2f, 0.1f) * (1.0f + std::sin(20.0f * d.x)) : vec3(0));
  });
  std::fill_n(picture.at(71, 40), 3, GetParam());
  const Environment e = filterEnvironment(picture);
  for (size_t level = 1; level < e.specular.size(); ++level) {
    const RadianceMap& map = e.specular[level];
    const double alpha = std::pow(kSpecularRoughness[level], 2.0);
    for (uint32_t k = 0; k < 40; ++k) {
      const uint32_t x = k * 7919 % (map.width - 1), y = k * 104729 % (map.width - 1);
      const float scale = 2.0f / static_cast<float>(map.width - 2);
      const vec3 d = shared::directionFromOctahedral(
          glm::vec2(static_cast<float>(x) * scale - 1.0f, static_cast<float>(y) * scale - 1.0f));
      glm::dvec3 sum(0);
      double whole = 0;
      for (uint32_t py = 0; py < picture.height; ++py) {
        const double row = std::sin((py + 0.5) / picture.height * std::numbers::pi);
        for (uint32_t px = 0; px < picture.width; ++px) {
          const double weight = row * lobe(glm::dot(d, pixelDirection(px + 0.5, py + 0.5, picture)), alpha);
          const float* p = picture.at(px, py);
          sum += glm::dvec3(p[0], p[1], p[2]) * weight;
          whole += weight;
        }
      }
      EXPECT_LE(relativeError(texel(map, x, y), sum / whole), 0.012f)
          << "level " << level << ", texel " << x << ", " << y;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(EnvironmentFilter, SunOfOnePixel, testing::Values(65504.0f, 300000.0f, 1e9f));

// A disk of radiance L and solid angle S at elevation e: the plane's irradiance is L S sin e. The resolution of the
// diffuse map and of the tree allows an error of 1 % at elevations of at least 15 degrees.
TEST(EnvironmentFilter, SunsBeyondHalvesKeepTheirIrradiance) {
  const bool full = latelight::test::runsInFull();
  for (const double degrees : {15.0, 40.0, 75.0}) {
    for (const float radiance : {3e5f, 1e9f}) {
      if (!full && (degrees == 40) == (radiance > 1e6f)) continue;  // half of them
      const double e = degrees * std::numbers::pi / 180;
      const vec3 sun(std::cos(e), 0, std::sin(e));
      double irradiance = 0, power = 0;  // of the pixels that show the sun, each with its own solid angle and elevation
      const FloatImage picture = makePicture(512, [&](const vec3& d) {
        const bool inside = glm::length(d - sun) < 0.012f;
        const double polar = std::acos(d.z), half = std::numbers::pi / 1024;
        const double light = radiance * (std::cos(polar - half) - std::cos(polar + half)) * 2 * std::numbers::pi / 1024;
        if (inside) power += light, irradiance += light * std::cos(polar);
        return vec3(inside ? radiance : 0.25f);
      });
      ASSERT_NEAR(irradiance, radiance * std::numbers::pi * 0.012 * 0.012 * std::sin(e), 0.15 * irradiance);
      const Environment environment = filterEnvironment(picture);
      const double found = lookUp(environment.diffuse, vec3(0, 0, 1)).x, sky = 0.25;
      const double exact = irradiance / std::numbers::pi + sky;
      EXPECT_NEAR(found, exact, 0.01 * exact) << degrees << " degrees, radiance " << radiance;
      // The mirror and the background show the sun itself.
      EXPECT_NEAR(lookUp(environment.specular[0], sun).x, radiance, 1e-3f * radiance);
      const glm::vec2 uv = shared::equirectangular(sun);
      EXPECT_EQ(texel(environment.radiance, size_t(uv.x * 1024), size_t(uv.y * 512)).x, radiance);
      // Every level of the specular maps contains the image's total light.
      const double light = power / (4 * std::numbers::pi) + sky;
      for (const RadianceMap& map : environment.specular) {
        EXPECT_TRUE(map.isFloat);
        glm::dvec3 sum(0);
        constexpr int kCount = 400000;
        for (int i = 0; i < kCount; ++i) sum += lookUp(map, spiral(i, kCount));
        EXPECT_NEAR(sum.x / kCount, light, 0.02 * light) << "a level of " << map.width;
      }
    }
  }
}

TEST(EnvironmentFilter, FloatsAreOnlyForWhatHalvesCannotHold) {
  FloatImage picture = makePicture(64, [](const vec3&) { return vec3(1); });
  std::fill_n(picture.at(40, 20), 3, 65519.0f);  // the last float that rounds to the largest half
  const Environment halves = filterEnvironment(picture);
  EXPECT_FALSE(halves.radiance.isFloat || halves.specular[0].isFloat || halves.diffuse.isFloat);
  EXPECT_EQ(texel(halves.radiance, 40, 20).x, kHalfMax);
  std::fill_n(picture.at(40, 20), 3, 65520.0f);
  const Environment floats = filterEnvironment(picture);
  EXPECT_TRUE(floats.radiance.isFloat);
  EXPECT_FALSE(floats.diffuse.isFloat) << "a mean of 17";
  EXPECT_EQ(texel(floats.radiance, 40, 20).x, 65520.0f);
  EXPECT_EQ(texel(floats.radiance, 41, 20).x, 1.0f);
}

TEST(EnvironmentFilter, SeamsDoNotShow) {
  const Environment e =
      filterEnvironment(makePicture(128, [](const vec3& d) { return vec3(2.0f) + vec3(d.x, d.y, d.x * d.y - d.z); }));
  std::vector<const RadianceMap*> maps{&e.diffuse};
  for (const RadianceMap& map : e.specular) maps.push_back(&map);
  for (const RadianceMap* map : maps) {
    const uint32_t edge = map->width - 2;
    for (uint32_t i = 0; i <= edge; ++i) {
      EXPECT_EQ(texel(*map, 0, i), texel(*map, 0, edge - i));
      EXPECT_EQ(texel(*map, i, edge), texel(*map, edge - i, edge));
      EXPECT_EQ(texel(*map, edge + 1, i), texel(*map, edge - 1, edge - i)) << "the spare column goes on over the edge";
      EXPECT_EQ(texel(*map, i, edge + 1), texel(*map, edge - i, edge - 1)) << "the spare row goes on over the edge";
    }
    EXPECT_EQ(texel(*map, 0, 0), texel(*map, edge, edge));
    EXPECT_EQ(texel(*map, 0, edge), texel(*map, edge, 0));
    // Steps of a thousandth of a radian across the folds (x = 0 or y = 0 below, and the equator) and along none.
    for (int i = 0; i < 2000; ++i) {
      const vec3 d = spiral(i, 2000);
      for (const vec3& plane : {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)}) {
        const vec3 on = glm::normalize(d - plane * glm::dot(d, plane));
        const vec3 before = lookUp(*map, glm::normalize(on - plane * 0.0005f));
        const vec3 after = lookUp(*map, glm::normalize(on + plane * 0.0005f));
        ASSERT_LE(glm::length(after - before), 0.006f) << "map of " << map->width << ", direction " << i;
      }
    }
  }
}

TEST(EnvironmentFilter, DirectionsAreTheDesigns) {
  FloatImage picture(256, 128);
  const auto paint = [&](uint32_t left, uint32_t right, uint32_t top, uint32_t bottom, const vec3& color) {
    for (uint32_t y = top; y < bottom; ++y) {
      for (uint32_t x = left; x < right; ++x) std::copy_n(&color.x, 3, picture.at(x, y));
    }
  };
  const vec3 red(1, 0, 0), green(0, 1, 0), blue(0, 0, 1), white(1, 1, 1), yellow(1, 1, 0), cyan(0, 1, 1);
  paint(0, 256, 0, 128, white);  // the rest of it: the ends, which meet at the back
  paint(96, 160, 0, 128, red);
  paint(160, 224, 0, 128, green);
  paint(32, 96, 0, 128, blue);
  paint(0, 256, 0, 24, yellow);
  paint(0, 256, 104, 128, cyan);
  const Environment e = filterEnvironment(picture);
  const auto expect = [&](const vec3& gltf, const vec3& color) {
    const vec3 d(toWorldFromGltf() * glm::vec4(gltf, 0.0f));
    for (size_t level = 0; level < 2; ++level) {
      EXPECT_LE(glm::length(lookUp(e.specular[level], d) - color), 0.05f)
          << level << ": " << gltf.x << gltf.y << gltf.z;
    }
    const glm::vec2 uv = shared::equirectangular(d);
    const auto column = std::min(static_cast<size_t>(uv.x * 256.0f), size_t{255});
    const auto row = std::min(static_cast<size_t>(uv.y * 128.0f), size_t{127});
    EXPECT_EQ(texel(e.radiance, column, row), color);
  };
  expect(vec3(1, 0, 0), red);
  expect(vec3(0, 0, 1), green);
  expect(vec3(0, 0, -1), blue);
  expect(vec3(-1, 0, 0), white);
  expect(vec3(0, 1, 0), yellow);
  expect(vec3(0, -1, 0), cyan);
}

TEST(EnvironmentFilter, AbsurdValuesAreClamped) {
  FloatImage picture = makePicture(32, [](const vec3&) { return vec3(1); });
  picture.at(3, 3)[0] = std::numeric_limits<float>::quiet_NaN();
  picture.at(9, 9)[1] = std::numeric_limits<float>::infinity();
  picture.at(20, 20)[2] = -5.0f;
  picture.at(30, 12)[0] = 1e30f;
  const Environment e = filterEnvironment(picture);
  EXPECT_EQ(texel(e.radiance, 3, 3).x, 0.0f);
  EXPECT_EQ(texel(e.radiance, 9, 9).y, kHalfMax) << "infinity is how files of halves write what is beyond them";
  EXPECT_EQ(texel(e.radiance, 20, 20).z, 0.0f);
  EXPECT_EQ(texel(e.radiance, 30, 12).x, kMaxRadiance);
  std::vector<RadianceMap> maps = e.specular;
  maps.push_back(e.diffuse);
  for (const RadianceMap& map : maps)
    for (const float value : toFloats(map).pixels)
      ASSERT_TRUE(value >= 0 && value <= 1.001f * kMaxRadiance) << value << " in a map of " << map.width;
}

// Sizes without common divisors, a picture that is wider than the stored one, and its mean.
TEST(EnvironmentFilter, ResizingKeepsTheMeanOverTheSphere) {
  const auto mean = [](const FloatImage& image) {
    double sum = 0, whole = 0;
    for (uint32_t y = 0; y < image.height; ++y) {
      const double weight =
          std::cos(y * std::numbers::pi / image.height) - std::cos((y + 1) * std::numbers::pi / image.height);
      for (uint32_t x = 0; x < image.width; ++x) sum += weight * image.at(x, y)[0], whole += weight;
    }
    return sum / whole;
  };
  FloatImage image(97, 31);
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<float>(i * 7919 % 101);
  const double exact = mean(image);
  for (const auto& [width, height] : {std::pair{64u, 32u}, {10u, 7u}, {1u, 1u}, {256u, 128u}, {97u, 31u}}) {
    EXPECT_NEAR(mean(resizeEquirectangular(image, width, height)), exact, 1e-4 * exact) << width << " x " << height;
  }
  const Environment e = filterEnvironment(FloatImage(5000, 20));
  EXPECT_EQ(e.radiance.width, 4096u);
  EXPECT_EQ(e.radiance.height, 16u);
}

TEST(EnvironmentFilter, StudioIsNeutralAndWellExposed) {
  const Environment e = filterEnvironment(makeStudio(256));
  vec3 mean(0);
  constexpr int kCount = 5000;
  for (int i = 0; i < kCount; ++i) mean += lookUp(e.diffuse, spiral(i, kCount)) / static_cast<float>(kCount);
  EXPECT_NEAR(mean.y, 0.5f, 0.05f);
  EXPECT_NEAR(mean.x / mean.y, 1.0f, 0.01f);
  EXPECT_NEAR(mean.z / mean.y, 1.0f, 0.01f);
  const float white = 0.8f * lookUp(e.diffuse, vec3(0, 0, 1)).y;
  EXPECT_GE(white, 0.7f);
  EXPECT_LE(white, 0.8f);
  EXPECT_GT(lookUp(e.diffuse, vec3(0, -1, 0)).y, lookUp(e.diffuse, vec3(0, 1, 0)).y)
      << "the viewer's side is the lit one";
  const vec3 left = lookUp(e.diffuse, vec3(-1, 0, 0)), right = lookUp(e.diffuse, vec3(1, 0, 0));
  EXPECT_GT(left.x, left.z);
  EXPECT_LT(right.x, right.z);
}

}  // namespace
}  // namespace latelight::scene
