// Several samples per pixel with every layout and every technique: all shade the same surfaces of a pixel, so all must
// agree.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "combinations/scene.h"
#include "long_tests.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/support.h"

namespace latelight::render::test {
namespace {

using output::Aov;
using Values = std::vector<float>;  // RGBA, linear

constexpr uint32_t kMsaaWidth = 48, kMsaaHeight = 27;

class MsaaCombinations : public RenderTest, public testing::WithParamInterface<std::string> {
 protected:
  struct Stage {
    scene::Scene scene = everyKind();
    scene::Environment environment = constantEnvironment();
    Renderer renderer;
    explicit Stage(vk::Device& device) : renderer(device, scene, &environment) {}
  };
  static void SetUpTestSuite() {
    if (!stage) stage = std::make_unique<Stage>(device());
  }
  static void TearDownTestSuite() { stage.reset(); }

  static output::FrameOutput render(const std::string& layout, const std::string& technique, uint32_t samples = 4,
                                    Raster raster = Raster::Hardware) {
    Settings settings = settingsOf(kMsaaWidth, kMsaaHeight, {Aov::Color});
    settings.raster = raster;
    settings.display = true;
    settings.environmentIntensity = 0.15f;
    settings.layout = &findLayout(layout);
    settings.lighting = &findTechnique(technique);
    settings.aa.samples = samples;
    return std::move(stage->renderer.render(stage->scene.cameras, inTheirRaster(settings)).front());
  }
  static std::unique_ptr<Stage> stage;
};
std::unique_ptr<MsaaCombinations::Stage> MsaaCombinations::stage;

int largestDifference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  int worst = a.size() == b.size() ? 0 : 256;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

size_t partlyCovered(const output::FrameOutput& frame) {
  const Values& color = imageOf(frame, Aov::Color).values;
  size_t count = 0;
  for (size_t i = 3; i < color.size(); i += 4) count += color[i] > 0 && color[i] < 1;
  return count;
}

// The number of pixels of two pictures that differ by more than so many levels of 255.
size_t pixelsBeyond(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b, int levels) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); i += 4) {
    int worst = 0;
    for (size_t c = i; c < i + 4; ++c) worst = std::max(worst, std::abs(a[c] - b[c]));
    count += worst > levels;
  }
  return count;
}

// For each number of samples and each raster, one technique besides fullscreen, in rotation. Every third layout is
// tested with 16 samples, which compute shaders process like four.
TEST_P(MsaaCombinations, LightsAlikeByEveryDeferredTechnique) {
  const std::string layout = findLayout(GetParam()).name;
  size_t turn = turnOf(layout);
  const bool many = turn % 3 == 0;
  if (!many) LATELIGHT_SKIP_UNLESS_ALL();
  const std::vector<uint8_t> jagged = render(layout, "fullscreen", 1).display;
  const auto check = [&](uint32_t samples, Raster raster) {
    SCOPED_TRACE(fmt::format("{} samples by {}", samples, nameOf(raster)));
    output::FrameOutput expected = render(layout, "fullscreen", samples, raster);
    EXPECT_GT(partlyCovered(expected), 10u);
    EXPECT_GT(largestDifference(expected.display, jagged), 32);  // smooth edges
    std::vector<std::string> others;
    for (const TechniqueInfo& technique : techniques())
      if (!technique.forward && technique.name != "fullscreen" && !(technique.draws && raster == Raster::Compute))
        others.push_back(technique.name);
    const std::string& technique = others[turn++ % others.size()];
    EXPECT_LE(largestDifference(render(layout, technique, samples, raster).display, expected.display), 1) << technique;
    return expected.display;
  };
  // Layouts that the hardware raster does not support are compared with a lossless one.
  const bool drawn = findLayout(layout).hasTargets();
  const std::vector<uint8_t> hardware = drawn ? check(4, Raster::Hardware) : render("exact", "fullscreen").display;
  const std::vector<uint8_t> compute = check(4, Raster::Compute);
  const size_t pixels = size_t{kMsaaWidth} * kMsaaHeight, beyond = pixelsBeyond(hardware, compute, 16);
  fmt::print("{}: {} of {} pixels differ between the rasters by more than 16 levels\n", layout, beyond, pixels);
  EXPECT_LE(beyond, pixels / 50);
  if (many) check(16, Raster::Compute);
}

INSTANTIATE_TEST_SUITE_P(All, MsaaCombinations, testing::ValuesIn(layoutNames()),
                         [](const testing::TestParamInfo<std::string>& info) { return findLayout(info.param).file; });

// Forward techniques shade each fragment, deferred ones each surface, at one point if its fragments belong to one
// surface. They therefore agree with each other, and with the lossless layout except where a surface's detail is finer
// than a pixel.
using MsaaForward = MsaaCombinations;
TEST_F(MsaaForward, LightsAlikeByBothTechniques) {
  const output::FrameOutput forward = render("plain", "forward"), multipass = render("plain", "forward-multipass");
  EXPECT_GT(partlyCovered(forward), 10u);
  EXPECT_LE(largestDifference(forward.display, multipass.display), 1);
  const Values& a = imageOf(forward, Aov::Color).values;
  const output::FrameOutput deferred = render("plain", "fullscreen");
  const Values& b = imageOf(deferred, Aov::Color).values;
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    sum += std::abs(std::min(a[i], 1.0f) - std::min(b[i], 1.0f));
    if (i % 4 == 3) {
      ASSERT_EQ(a[i], b[i]) << "coverage of pixel " << i / 4;
    }
  }
  fmt::print("forward and fullscreen differ by {:.5f} in the mean\n", sum / static_cast<double>(a.size()));
  EXPECT_LT(sum / static_cast<double>(a.size()), 0.003);
}

}  // namespace
}  // namespace latelight::render::test
