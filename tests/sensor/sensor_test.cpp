// The sensor against its model: moments of the noise, closed forms of vignetting, mosaics and curves.
#include "render/sensor/sensor.h"

#include <fmt/core.h>

#include <cmath>

#include "base/error.h"
#include "render/sensor/development.h"
#include "render/sensor/exposure_plane.h"
#include "render/sensor/mosaic.h"
#include "render/sensor/vignetting.h"
#include "render/support.h"

namespace latelight::render::test {
namespace {

using output::Aov;

constexpr uint32_t kWidth = 96, kHeight = 80;

Settings sensor(uint32_t width = kWidth, uint32_t height = kHeight) {
  Settings s = settingsOf(width, height, {Aov::Color});
  s.bitDepth = 16;
  return s;
}

// An RGBA picture of a function of column, row and channel.
template <typename F>
std::vector<float> pictureOf(const Settings& s, const F& value) {
  std::vector<float> rgba;
  for (uint32_t y = 0; y < s.height; ++y)
    for (uint32_t x = 0; x < s.width; ++x) {
      for (uint32_t k = 0; k < 3; ++k) rgba.push_back(static_cast<float>(value(x, y, k)));
      rgba.push_back(1);
    }
  return rgba;
}

// --- noise ----------------------------------------------------------------------------------------------------------

struct Moments {
  double mean = 0, variance = 0;
  size_t count = 0;
};
Moments momentsOf(const std::vector<float>& values) {
  Moments m{.count = values.size()};
  for (const float v : values) m.mean += v / double(m.count);
  for (const float v : values) m.variance += (v - m.mean) * (v - m.mean) / double(m.count - 1);
  return m;
}

// EMVA 1288, equations 8 to 10: the mean is K mu, the variance K^2 (mu + read^2) + 1/12, in digital numbers. The
// estimates' own errors are five standard deviations at most.
TEST(SensorNoise, HasTheMomentsOfTheModel) {
  struct Case {
    double fullWell, gain, readNoise, light;
    uint32_t bits, black;
  };
  for (const Case& c : {Case{10000, 1, 0, 0.5, 12, 0},
                        {10000, 1, 5, 0.25, 12, 64},
                        {20000, 8, 12, 0.1, 14, 512},
                        {100, 1, 2, 0.03, 10, 40},
                        {500, 1, 3, 0, 12, 128},
                        {30000, 4, 0, 0.002, 16, 100}}) {
    Settings s = sensor(200, 150);
    s.fullWell = c.fullWell, s.gain = c.gain, s.readNoise = c.readNoise, s.bitDepth = c.bits, s.blackLevel = c.black;
    const SensorPlane plane = exposeSensor(pictureOf(s, [&](auto...) { return c.light; }), s, 7);
    const double range = (1u << c.bits) - 1.0 - c.black, perElectron = c.gain / c.fullWell * range;
    const double electrons = c.light * c.fullWell / c.gain;
    std::vector<float> numbers;
    for (const float v : plane.rgb) numbers.push_back(static_cast<float>(v * range));
    for (const float v : numbers) ASSERT_NEAR(v, std::round(v), 4e-3);
    const Moments m = momentsOf(numbers);
    const double variance = perElectron * perElectron * (electrons + c.readNoise * c.readNoise) + 1.0 / 12;
    const double n = double(m.count);
    // The excess kurtosis of a Poisson distribution is 1 / mean.
    const double kurtosis = electrons > 0 ? 1 / electrons : 0;
    EXPECT_NEAR(m.mean, electrons * perElectron, 5 * std::sqrt(variance / n) + 0.01) << c.fullWell << " " << c.light;
    EXPECT_NEAR(m.variance, variance, 5 * variance * std::sqrt((2 + kurtosis) / n) + 0.03 * (perElectron < 1))
        << c.fullWell << " " << c.light;
  }
}

TEST(SensorNoise, EndsAtTheWellAndTheConverter) {
  Settings s = sensor();
  s.fullWell = 1000, s.readNoise = 3, s.bitDepth = 10, s.blackLevel = 20;
  const auto extreme = [&](double light) {
    const std::vector<float> raw = mosaicOf(exposeSensor(pictureOf(s, [&](auto...) { return light; }), s, 0), s);
    return std::minmax_element(raw.begin(), raw.end());
  };
  EXPECT_EQ(*extreme(1e30).second, 1023);
  EXPECT_GE(*extreme(1e30).first, 1023 - 5 * 3 * 1003 / 1000.0);  // the well is full, and reading adds its noise
  EXPECT_LT(*extreme(0).first, 20);                               // below black
  EXPECT_GT(*extreme(0).second, 20);
  s.gain = 0.5;  // the well is full before the converter is
  EXPECT_LE(*extreme(1e30).second, 20 + 0.5 * 1003 * 1.03);
}

// Each pixel has its own random numbers: they depend on the seeds and not on the signal of other pixels.
TEST(SensorNoise, DependsOnSeedsAndPixelsOnly) {
  Settings s = sensor();
  s.fullWell = 1000, s.readNoise = 2;
  const auto half = pictureOf(s, [](auto...) { return 0.5; });
  const auto other = pictureOf(s, [](uint32_t x, uint32_t, uint32_t) { return x < 50 ? 0.5 : 0.1; });
  const SensorPlane a = exposeSensor(half, s, 3), b = exposeSensor(half, s, 3), c = exposeSensor(half, s, 4);
  const SensorPlane d = exposeSensor(other, s, 3);
  s.noiseSeed = 9;
  const SensorPlane e = exposeSensor(half, s, 3);
  EXPECT_EQ(a.rgb, b.rgb);
  const auto correlation = [](const std::vector<float>& one, const std::vector<float>& two) {
    const Moments m = momentsOf(one), n = momentsOf(two);
    double sum = 0;
    for (size_t i = 0; i < one.size(); ++i) sum += (one[i] - m.mean) * (two[i] - n.mean) / double(one.size());
    return sum / std::sqrt(m.variance * n.variance);
  };
  const double five = 5 / std::sqrt(double(a.rgb.size()));
  EXPECT_LE(std::abs(correlation(a.rgb, c.rgb)), five);
  EXPECT_LE(std::abs(correlation(a.rgb, e.rgb)), five);
  EXPECT_LE(std::abs(correlation({a.rgb.begin(), a.rgb.end() - 1}, {a.rgb.begin() + 1, a.rgb.end()})), five);
  for (uint32_t y = 0; y < kHeight; ++y)
    for (uint32_t i = 3 * kWidth * y; i < 3 * (kWidth * y + 50); ++i) ASSERT_EQ(a.rgb[i], d.rgb[i]);
}

// --- mosaics --------------------------------------------------------------------------------------------------------

TEST(SensorMosaic, ReadsTheColorOfEachFilter) {
  for (const auto& [bayer, rows] : {std::pair{Bayer::None, "rggb"},
                                    {Bayer::Rggb, "rggb"},
                                    {Bayer::Bggr, "bggr"},
                                    {Bayer::Grbg, "grbg"},
                                    {Bayer::Gbrg, "gbrg"}}) {
    Settings s = sensor(5, 3);
    s.bayer = bayer, s.bitDepth = 8, s.blackLevel = 5;
    const auto color = pictureOf(s, [](uint32_t, uint32_t, uint32_t k) { return 0.2 * (k + 1); });
    const std::vector<float> raw = mosaicOf(exposeSensor(color, s, 0), s);
    for (uint32_t y = 0; y < 3; ++y)
      for (uint32_t x = 0; x < 5; ++x) {
        const char filter = rows[2 * (y % 2) + x % 2];
        EXPECT_EQ(raw[5 * y + x], 5 + 50 * (filter == 'r' ? 1 : filter == 'g' ? 2 : 3)) << rows << x << y;
      }
  }
}

// The filters reproduce gradients that the colors share, up to a constant difference, except at the borders, where the
// mosaic is mirrored.
TEST(SensorMosaic, InterpolatesGradientsExactly) {
  for (const Bayer bayer : {Bayer::Rggb, Bayer::Bggr, Bayer::Grbg, Bayer::Gbrg}) {
    Settings s = sensor();
    s.bayer = bayer;
    s.whiteBalance.factors = {2, 1, 1.5};
    const auto expected = [](uint32_t x, uint32_t y, uint32_t k) { return 0.1 + 0.003 * x + 0.002 * y + 0.1 * k; };
    const auto measured = pictureOf(s, [&](uint32_t x, uint32_t y, uint32_t k) {
      return expected(x, y, k) / s.whiteBalance.factors[static_cast<int>(k)];
    });
    const std::vector<float> picture = linearPicture(exposeSensor(measured, s, 0), measured, s);
    for (uint32_t y = 2; y < kHeight - 2; ++y)
      for (uint32_t x = 2; x < kWidth - 2; ++x)
        for (uint32_t k = 0; k < 3; ++k)
          ASSERT_NEAR(picture[4 * (y * kWidth + x) + k], expected(x, y, k), 2e-6) << x << "," << y << "," << k;
  }
  // Pictures of any size have mirrored borders, and a constant stays one.
  for (const auto& [width, height] : {std::pair{1u, 1u}, {1u, 7u}, {2u, 2u}, {3u, 1u}}) {
    Settings s = sensor(width, height);
    s.bayer = Bayer::Grbg;
    const auto gray = pictureOf(s, [](auto...) { return 0.25; });
    const std::vector<float> picture = linearPicture(exposeSensor(gray, s, 0), gray, s);
    EXPECT_EQ(picture.size(), gray.size());
    if (width > 1 && height > 1) {
      EXPECT_EQ(picture, gray);
    }
  }
}

// --- vignetting -----------------------------------------------------------------------------------------------------

TEST(SensorVignetting, FollowsItsFormula) {
  Settings s = sensor();
  scene::Camera camera = frontPerspective(1.2f, 3);
  camera.principal = {0.2f, -0.1f};
  const glm::dvec2 axis(kWidth * 0.6, kHeight * 0.55);
  const double f = kHeight * 0.5 / std::tan(0.5 * double{1.2f}), farthest = glm::length(axis);
  const auto lit = [&](const scene::Camera& from) {
    std::vector<float> rgba = pictureOf(s, [](auto...) { return 1; });
    darken(rgba, s, from);
    return rgba;
  };
  const auto expect = [&](const std::vector<float>& rgba, const glm::dvec2& center, auto&& formula) {
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        ASSERT_NEAR(rgba[4 * (y * kWidth + x) + 1], formula(glm::distance({x + 0.5, y + 0.5}, center)), 1e-5);
        ASSERT_EQ(rgba[4 * (y * kWidth + x) + 3], 1);
      }
  };
  s.vignetting.cos4 = true;
  expect(lit(camera), axis, [&](double r) { return std::pow(f * f / (f * f + r * r), 2); });
  scene::Camera fisheye = camera;
  fisheye.lens = scene::Lens{
      .model = scene::LensModel::Fisheye, .width = kWidth, .height = kHeight, .fx = 40, .fy = 40, .cx = 48, .cy = 40};
  expect(lit(fisheye), {48, 40}, [&](double r) { return std::pow(std::max(std::cos(r / 40), 0.0), 4); });
  for (const scene::Camera& flat : {frontCamera()}) EXPECT_EQ(lit(flat)[1], 1);
  s.vignetting = {.coefficients = {-0.3, -0.2, 0.1}};
  expect(lit(camera), axis, [&](double r) {
    const double q = r * r / (farthest * farthest);
    return 1 - 0.3 * q - 0.2 * q * q + 0.1 * q * q * q;
  });
}

// --- curves ---------------------------------------------------------------------------------------------------------

TEST(SensorResponse, MapsTheSignal) {
  Settings s = sensor(5, 1);
  const float signals[] = {-0.1f, 0, 0.25f, 0.9f, 3};
  const auto picture = pictureOf(s, [&](uint32_t x, uint32_t, uint32_t) { return signals[x]; });
  const auto codes = [&] {
    std::vector<int> reds;
    const std::vector<uint8_t> rgba = developed(picture, s);
    for (size_t i = 0; i < 5; ++i) reds.push_back(rgba[4 * i]);
    return reds;
  };
  s.response = {.gamma = 2};
  EXPECT_EQ(codes(), (std::vector{0, 0, 128, 242, 255}));  // 255 sqrt(0.25) = 127.5, 255 sqrt(0.9) = 241.9
  s.response = {.values = {0, 1}};
  EXPECT_EQ(codes(), (std::vector{0, 0, 64, 230, 255}));
  s.response = {.values = {0.2, 0.6, 0.8}};  // at 0, 1/2 and 1
  EXPECT_EQ(codes(), (std::vector{51, 51, 102, 194, 204}));
  s.response = {};
  s.tonemap = Tonemap::None;
  EXPECT_EQ(codes(), (std::vector{0, 0, 137, 243, 255}));  // sRGB of 0.25 is 0.5371, of 0.9 it is 0.9547
}

TEST(SensorJpeg, LosesLessWithMoreQuality) {
  const uint32_t width = 61, height = 43;
  std::vector<uint8_t> original;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      for (const uint32_t v : {(x * x) / 15, x * y / 11, 3 * x + 2 * y, 200 + x % 7}) original.push_back(v % 256);
  double before = 1e9;
  for (const uint32_t quality : {1u, 20u, 60u, 95u}) {
    std::vector<uint8_t> picture = original;
    addJpegArtifacts(picture, width, height, quality);
    double error = 0;
    for (size_t i = 0; i < picture.size(); ++i) {
      if (i % 4 == 3) {
        ASSERT_EQ(picture[i], original[i]);
      }
      error += std::abs(picture[i] - original[i]);
    }
    EXPECT_LT(error, before);
    EXPECT_GT(error, 0);
    before = error;
  }
  std::vector<uint8_t> gray(original.size(), 77);
  addJpegArtifacts(gray, width, height, 90);
  EXPECT_EQ(gray, std::vector<uint8_t>(original.size(), 77));
}

// --- pictures -------------------------------------------------------------------------------------------------------

class SensorTest : public RenderTest {
 protected:
  static Settings picture() {
    Settings s = settingsOf(kWidth, kHeight, {Aov::Color, Aov::Raw, Aov::Depth});
    s.display = true;
    return s;
  }
  static output::FrameOutput render(const scene::Scene& scene, const Settings& s) {
    return renderOne(device(), scene, cameraOf(scene, kWidth, kHeight), s);
  }
};

// With next to no noise, the host finishes the picture as the device does.
TEST_F(SensorTest, AnIdealSensorChangesNothing) {
  Settings s = picture();
  s.exposure = -2;
  s.aa.superSampling = 2;
  s.background = {.kind = Background::Color, .color = glm::vec3(0)};
  const output::FrameOutput ideal = render(hall(), s);
  s.fullWell = 1e9;
  s.bitDepth = 16;
  const output::FrameOutput real = render(hall(), s);
  size_t compared = 0;
  for (size_t i = 0; i < ideal.display.size(); ++i) {
    const float* light = &imageOf(ideal, Aov::Color).values[i / 4 * 4];
    if (std::max({light[0], light[1], light[2]}) > 0.99f) continue;  // the sensor is saturated
    ++compared;
    ASSERT_NEAR(ideal.display[i], real.display[i], 1) << i;
    ASSERT_NEAR(imageOf(ideal, Aov::Color).values[i], imageOf(real, Aov::Color).values[i], 2e-3);
  }
  EXPECT_GT(compared, ideal.display.size() / 2);
  EXPECT_EQ(imageOf(ideal, Aov::Depth).values, imageOf(real, Aov::Depth).values);
  EXPECT_NEAR(imageOf(ideal, Aov::Raw).values[1000], imageOf(real, Aov::Raw).values[1000] / 16,
              2);  // of 12 and 16 bits
}

// Strips, the order of views and what else is requested do not change the noise; the frame's seed does.
TEST_F(SensorTest, NoiseIsThatOfTheFrame) {
  const scene::Scene& scene = hall();
  Settings s = picture();
  s.fullWell = 2000, s.readNoise = 4, s.bayer = Bayer::Gbrg, s.blackLevel = 100, s.jpegQuality = 80;
  scene::Camera one = cameraOf(scene, kWidth, kHeight), two = one;
  two.noiseSeed = 1;
  Renderer renderer(device(), scene, nullptr);
  const std::vector<scene::Camera> order{one, two}, reversed{two, one};
  const auto a = renderer.render(order, s), b = renderer.render(reversed, s);
  EXPECT_EQ(a[0].display, b[1].display);
  EXPECT_EQ(a[1].display, b[0].display);
  EXPECT_EQ(imageOf(a[0], Aov::Raw).values, imageOf(b[1], Aov::Raw).values);
  EXPECT_NE(a[0].display, a[1].display);
  Settings strips = s;
  strips.aovs = {Aov::Raw};
  strips.stripPixels = kWidth * 64;
  const auto c = renderer.render({&one, 1}, strips);
  ASSERT_EQ(c[0].aovs.size(), 1u);
  // A strip's light may round differently by a half float's last bit.
  size_t differing = 0;
  for (size_t i = 0; i < kWidth * kHeight; ++i)
    differing += c[0].aovs[0].values[i] != imageOf(a[0], Aov::Raw).values[i];
  EXPECT_LE(differing, kWidth * kHeight / 200);
}

TEST_F(SensorTest, RejectsWhatItCannotDo) {
  Settings s = picture();
  s.blackLevel = 4095;
  EXPECT_THROW(render(hall(), s), Error);
  s = picture();
  s.aa.fxaa = true, s.fullWell = 100;
  EXPECT_THROW(render(hall(), s), Error);
  for (const char* text : {"", "cos", "1,2,3,4", "nan", "11"}) EXPECT_THROW(readText<Vignetting>("-", text), Error);
  for (const char* text : {"", "1,1", "-1,1,1", "1,1,1001"}) EXPECT_THROW(readText<WhiteBalance>("-", text), Error);
  for (const char* text : {"", "0.5", "gamma:0", "gamma:", "0,2", "curve"})
    EXPECT_THROW(readText<Response>("-", text), Error);
}

}  // namespace
}  // namespace latelight::render::test
