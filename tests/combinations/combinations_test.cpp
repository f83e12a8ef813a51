// Every valid combination of layout, normal encoding, lighting technique and position method renders the same picture
// as `fullscreen` from the same G-buffer.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <span>

#include "combinations/scene.h"
#include "render/base/registry.h"
#include "render/frame/view.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/support.h"

namespace latelight::render::test {
namespace {

constexpr uint32_t kWidth = 64, kHeight = 36;

using Picture = std::vector<uint8_t>;  // RGBA

int worstDifference(const Picture& a, const Picture& b) {
  if (a.size() != b.size()) return 256;
  int worst = 0;
  for (size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

// The share of pixels whose largest channel difference exceeds so many levels.
double shareBeyond(const Picture& a, const Picture& b, int levels) {
  size_t beyond = 0;
  for (size_t i = 0; i < a.size(); i += 4) {
    int worst = 0;
    for (size_t c = 0; c < 4; ++c) worst = std::max(worst, std::abs(a[i + c] - b[i + c]));
    beyond += worst > levels;
  }
  return static_cast<double>(beyond) / static_cast<double>(a.size() / 4);
}

double meanSquare(const Picture& a, const Picture& b) {
  if (a.size() != b.size()) return 1e9;
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

// A picture of the background would agree with any other. This one must be covered, with bright and dark parts.
void expectContent(const Picture& picture) {
  size_t covered = 0, dark = 0, bright = 0;
  for (size_t i = 0; i < picture.size(); i += 4) {
    const int largest = std::max({picture[i], picture[i + 1], picture[i + 2]});
    covered += picture[i + 3] == 255;
    dark += largest < 64;
    bright += largest > 160;
  }
  EXPECT_GT(covered, size_t{kWidth} * kHeight / 2);
  EXPECT_LT(covered, size_t{kWidth} * kHeight);
  EXPECT_GT(dark, size_t{kWidth} * kHeight / 50);
  EXPECT_GT(bright, size_t{kWidth} * kHeight / 50);
}

struct Stage {
  scene::Scene scene = everyKind();
  scene::Environment environment = constantEnvironment();
  Renderer renderer;
  Settings settings = settingsOf(kWidth, kHeight);
  size_t combinations = 0;

  explicit Stage(vk::Device& device) : renderer(device, scene, &environment) {
    settings.display = true;
    settings.environmentIntensity = 0.15f;
  }
  Picture render(const std::string& technique) {
    settings.lighting = &findTechnique(technique);
    ++combinations;
    return std::move(renderer.render(scene.cameras, inTheirRaster(settings)).front().display);
  }
};

// All techniques of this kind except fullscreen.
std::vector<TechniqueInfo> otherTechniques(bool forward) {
  std::vector<TechniqueInfo> others;
  for (const TechniqueInfo& technique : techniques())
    if (technique.forward == forward && technique.name != "fullscreen") others.push_back(technique);
  return others;
}

class CombinationsTest : public RenderTest {
 protected:
  static void SetUpTestSuite() {
    if (!stage) stage = std::make_unique<Stage>(device());
  }
  static void TearDownTestSuite() { stage.reset(); }
  static std::unique_ptr<Stage> stage;

  // Compares these techniques with fullscreen, with the stage's settings.
  static void compareTechniques(std::span<const TechniqueInfo> others) {
    const Picture expected = stage->render("fullscreen");
    expectContent(expected);
    for (const TechniqueInfo& technique : others) {
      if (technique.draws && lightsTriangles(stage->settings)) continue;
      SCOPED_TRACE(technique.name);
      EXPECT_LE(worstDifference(stage->render(technique.name), expected), 1);
    }
  }
};
std::unique_ptr<Stage> CombinationsTest::stage;

class EachLayout : public CombinationsTest, public testing::WithParamInterface<std::string> {};

// Every layout is combined with every encoding and every position method, each with one technique besides fullscreen,
// in rotation; all combinations would mostly build pipelines. The first ones are tested with every technique.
TEST_P(EachLayout, LightsAlikeByEveryTechnique) {
  const Layout& layout = findLayout(GetParam());
  const std::vector<TechniqueInfo> others = otherTechniques(false);
  const size_t encodings = layout.fixedNormal ? 1 : normalEncodings().size();
  const size_t positions = layout.fixedPosition ? 1 : choices<PositionMethod>().size();
  stage->settings.layout = &layout;
  stage->combinations = 0;
  const size_t first = turnOf(layout.name);
  for (size_t turn = 0; turn < std::max(encodings, positions); ++turn) {
    const NormalEncoding& encoding = normalEncodings()[turn % encodings];
    const NamedOption& position = choices<PositionMethod>()[(first + turn) % positions];
    stage->settings.normals = &encoding;
    stage->settings.position = choiceNamed<PositionMethod>(position.name).value();
    SCOPED_TRACE(fmt::format("{}, {} normals, position by {}", layout.name, encoding.name, position.name));
    compareTechniques(turn == 0 ? others : std::vector{others[(first + turn) % others.size()]});
  }
  fmt::print("{}: {} combinations of {}; of position by {}; of fullscreen, {}\n", layout.name, stage->combinations,
             layout.fixedNormal ? "its own normals" : namesOf(normalEncodings()),
             layout.fixedPosition ? "itself" : namesOf(choices<PositionMethod>()), namesOf(others));
}

INSTANTIATE_TEST_SUITE_P(All, EachLayout, testing::ValuesIn(layoutNames()),
                         [](const testing::TestParamInfo<std::string>& info) { return findLayout(info.param).file; });

// Each layout is tested with one of the other formats, in rotation. Rays have sharper edges than any map; tests/rays
// compares them with closed forms.
TEST_P(EachLayout, ShadowsAlikeByEveryFormat) {
  const Layout& layout = findLayout(GetParam());
  stage->settings.layout = &layout;
  stage->settings.normals = &findNormalEncoding("octahedral");
  stage->settings.position = PositionMethod::Ray;
  const Picture unshadowed = stage->render("fullscreen");
  stage->settings.shadows = ShadowFormat::D32;
  const Picture expected = stage->render("fullscreen");
  EXPECT_GT(worstDifference(unshadowed, expected), 50);
  std::vector<std::string> others;
  for (const NamedOption& format : choices<ShadowFormat>())
    if (format.name != std::string("none") && format.name != std::string("d32") && format.name != std::string("rays"))
      others.push_back(format.name);
  const std::string& format = others[turnOf(layout.name) % others.size()];
  stage->settings.shadows = choiceNamed<ShadowFormat>(format).value();
  // If a point lies exactly at the stored depth, rounding decides; with 16 bits this happens more often.
  EXPECT_LE(shareBeyond(stage->render("fullscreen"), expected, 2), 0.01) << format;
  stage->settings.shadows = ShadowFormat::None;
}

// More samples bring the picture closer to that of 16 samples per pixel. FXAA has one sample and can only estimate in
// this scene, whose shapes are a few pixels wide, so it only has to stay about as close. The tests of the renderer
// cover other numbers of samples.
TEST_P(EachLayout, SmoothsEdgesByEveryAntiAliasing) {
  stage->settings.layout = &findLayout(GetParam());
  stage->settings.normals = &findNormalEncoding("octahedral");
  stage->settings.position = PositionMethod::Ray;
  const auto render = [](const std::string& name) {
    const Settings kept = stage->settings;
    stage->settings.aa = readText<AntiAliasing>("--aa", name);
    Picture picture = stage->render("fullscreen");
    stage->settings = kept;
    return picture;
  };
  const Picture smooth = render("ss4");
  const double jagged = meanSquare(render("none"), smooth);
  std::string report;
  for (const AntiAliasingMode& aa : antiAliasingModes()) {
    const std::string name = aa.sets ? aa.name : "ss2";  // ssN
    if (name == "none" || (name.starts_with("msaa") && name != "msaa4")) continue;
    const double share = meanSquare(render(name), smooth) / jagged;
    EXPECT_LT(share, name == "fxaa" ? 1.25 : 0.15) << name;
    EXPECT_NE(share, 1) << name << " changes nothing";
    report += fmt::format(" {} {:.2f}", name, share);
  }
  fmt::print("{}: of the squared error without, to ss4:{}\n", GetParam(), report);
}

// Every deferred technique reads shadow maps in the same way, tested with one layout, and with one that stores the
// sun's shadow.
TEST_F(CombinationsTest, ShadowsAlikeByEveryTechnique) {
  stage->settings.shadows = ShadowFormat::D32;
  for (const char* layout : {"thin", "killzone2"}) {
    SCOPED_TRACE(layout);
    stage->settings.layout = &findLayout(layout);
    compareTechniques(otherTechniques(false));
  }
  stage->settings.shadows = ShadowFormat::None;
}

// Forward techniques have no layout: they shade the same values that a lossless layout stores.
class ForwardTechniques : public CombinationsTest {};

TEST_F(ForwardTechniques, LightAlikeTheFloatsOfPlain) {
  stage->settings.layout = &findLayout("plain");
  compareTechniques(otherTechniques(true));
  stage->settings.shadows = ShadowFormat::D32;
  compareTechniques(otherTechniques(true));
  stage->settings.shadows = ShadowFormat::None;
}

// --- without a G-buffer ---------------------------------------------------------------------------------------------

// A shader that evaluates and lights a surface at once uses the same floats that the layout `exact` stores in between.
// The picture is therefore equal, byte for byte if both are compiled in the same way, as on the CPU device. Only the
// emitted light differs there: the light accumulation target rounds it to a half float before the rest is added, so the
// sum differs by one step.
class WithoutTargets : public RenderTest {
 protected:
  // Without textures on a CPU device, where the driver filters those of a G-buffer (visibility/resolve.h).
  static scene::Scene filteredAlike() {
    scene::Scene scene = everyKind();
    if (!device().isCpu()) return scene;
    for (scene::Material& m : scene.materials) {
      m.data.textures = 0;
      for (scene::TextureSlot& slot : m.slots) slot.texture = -1;
    }
    return scene;
  }
  static std::vector<float> colorOf(Renderer& renderer, std::span<const scene::Camera> cameras, Settings settings,
                                    const char* layout) {
    settings.layout = &findLayout(layout);
    std::vector<float> all;
    for (const output::FrameOutput& frame : renderer.render(cameras, settings)) {
      const std::vector<float>& color = imageOf(frame, output::Aov::Color).values;
      all.insert(all.end(), color.begin(), color.end());
    }
    return all;
  }
  static Settings settings() {
    Settings s = settingsOf(kWidth, kHeight, {output::Aov::Color});
    s.raster = Raster::Compute;
    s.environmentIntensity = 0.15f;
    return s;
  }
  // Returns true if the values differ by at most `steps` half floats.
  static void expectAlike(Renderer& renderer, std::span<const scene::Camera> cameras, const Settings& s, float steps) {
    const std::vector<float> exact = colorOf(renderer, cameras, s, "exact");
    const std::vector<float> found = colorOf(renderer, cameras, s, "visibility");
    ASSERT_EQ(found.size(), exact.size());
    size_t beyond = 0, covered = 0;
    for (size_t i = 0; i < exact.size(); ++i) {
      beyond += !(std::abs(found[i] - exact[i]) <= steps * std::max(std::ldexp(std::abs(exact[i]), -10), 6e-8f));
      covered += i % 4 == 3 && exact[i] > 0;
    }
    EXPECT_GT(covered, cameras.size() * kWidth * kHeight / 2);
    EXPECT_LE(beyond, device().isCpu() ? 0 : exact.size() / 1000);
  }
};

TEST_F(WithoutTargets, ThePictureIsThatOfFloats) {
  scene::Scene scene = filteredAlike();
  for (scene::Material& m : scene.materials) m.data.emissive = shared::vec3(0), m.data.flags &= ~shared::kMaterialUnlit;
  const scene::Environment environment = constantEnvironment();
  Renderer renderer(device(), scene, &environment);
  std::vector<scene::Camera> cameras(2, scene.cameras.front());
  cameras[1].toWorld[3].x += 0.4f;
  const float steps = device().isCpu() ? 0 : 2;
  const auto check = [&](const char* what, const Settings& s, float steps) {
    SCOPED_TRACE(what);
    expectAlike(renderer, cameras, s, steps);
  };
  Settings s = settings();
  for (const char* technique : {"clustered", "fullscreen"}) {
    s.lighting = &findTechnique(technique);
    check(technique, s, steps);
  }
  s.lighting = &findTechnique("tiled"), s.shading = Shading::GgxCompensated;
  s.shadows = ShadowFormat::D32, s.ambientOcclusion = AmbientOcclusion::Gtao;
  s.fogDensity = 0.05f, s.background.kind = Background::Environment;
  check("tiled, with shadows, occlusion and fog", s, steps);
  s.aa = {.superSampling = 2};
  check("super-sampled", s, steps);
  // Shades every sample separately; otherwise a G-buffer would shade triangles of one surface once. Positions of
  // samples come from depth in `exact`, too, which may round a color to the next half float.
  s.aa = {.samples = 4}, s.everySample = true;
  check("four samples", s, std::max(steps, 1.0f));
}

TEST_F(WithoutTargets, WhatIsEmittedIsRoundedOnce) {
  const scene::Scene scene = filteredAlike();
  Renderer renderer(device(), scene, nullptr);
  expectAlike(renderer, scene.cameras, settings(), 1);
}

// The layout's description of its positions decides with which position methods it is rendered.
TEST(FixedPositions, AreThoseThatDepthDoesNotChange) {
  shared::GbufferContext context{};
  context.view = makeView(frontPerspective(1, 4), 4, 4);
  for (const Layout& layout : layouts()) {
    if (!layout.hasTargets()) continue;
    const std::vector<TargetValue> stored(layout.targets.size());
    context.depth = 0.1f;
    const shared::vec3 nearer = layout.unpack(stored, context).position;
    context.depth = 0.01f;
    EXPECT_EQ(layout.unpack(stored, context).position == nearer, layout.fixedPosition != nullptr) << layout.name;
  }
}

}  // namespace
}  // namespace latelight::render::test
