// On a CPU device, passes run only for the tiles of a picture that surfaces cover, and load constants in the CPU's way.
// The code paths for GPUs, on the same device, give the same bytes without a list of tiles.
#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <iterator>

#include "render/support.h"

namespace latelight::render::test {
namespace {

using output::Aov;

// Outputs with constant and with view-dependent backgrounds, and more than one pass packs.
const std::vector<Aov> kPackedOutputs = {Aov::Color,     Aov::Depth,  Aov::Distance, Aov::Normal,
                                         Aov::GeoNormal, Aov::Albedo, Aov::Id,       Aov::Material,
                                         Aov::Uv,        Aov::Ao,     Aov::Roughness};

struct PictureSize {
  uint32_t width, height;
};
constexpr PictureSize kPictureSizes[] = {{1, 311}, {23, 17}, {641, 479}};

// Squares: one around the origin with half the given side, and two that cover few pixels near the picture's corners.
scene::Scene threeSquares(float half, bool blended) {
  scene::SceneBuilder builder("squares");
  scene::Scene& scene = builder.scene;
  scene.meshes = {squareMesh()};
  scene::Material& material = scene.materials.emplace_back(scene::plainMaterial("m", {0.8f, 0.5f, 0.3f}, 0.2f, 0.4f));
  material.data.baseColor.a = blended ? 0.5f : 1;
  if (blended) material.data.flags |= shared::kMaterialBlended;
  const auto place = [&](const glm::vec3& at, float scale) {
    builder.addInstance("square", builder.kRoot, 0, 0, glm::scale(glm::translate(glm::mat4(1), at), glm::vec3(scale)));
  };
  place({0, 0, 0}, half);
  place({0.93f, 0.88f, 0.1f}, 0.02f * half);
  place({-0.97f, -0.91f, 0.1f}, 0.01f * half);
  scene::Light& light = scene.lights.emplace_back();
  light.type = shared::kLightPoint;
  light.position = {0.3f, -1, 0.4f};
  light.intensity = 2;
  return std::move(scene);
}

scene::Camera shifted(float x) {
  scene::Camera camera = frontCamera();
  camera.toWorld[3].x += x;
  return camera;
}

void expectEqualBytes(const output::FrameOutput& a, const output::FrameOutput& b) {
  EXPECT_FALSE(a.display.empty());
  EXPECT_TRUE(a.display == b.display) << "display";
  ASSERT_EQ(a.aovs.size(), b.aovs.size());
  for (size_t i = 0; i < a.aovs.size(); ++i) {
    const std::vector<float>&x = a.aovs[i].values, &y = b.aovs[i].values;
    ASSERT_EQ(x.size(), y.size());
    EXPECT_TRUE(x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof(float)) == 0)
        << output::info(a.aovs[i].aov).name;
    EXPECT_TRUE(a.aovs[i].ids == b.aovs[i].ids) << output::info(a.aovs[i].aov).name;
  }
}

class CoveredTiles : public RenderTest {
 protected:
  void compare(const scene::Scene& scene, const Settings& settings) {
    const scene::Environment studio = scene::loadEnvironment("studio");
    const scene::Environment* environment = settings.background.kind == Background::Environment ? &studio : nullptr;
    const std::vector<scene::Camera> cameras = {shifted(0), shifted(0.7f), shifted(50)};  // the last one sees nothing
    Renderer tiles(device(), scene, environment), all(gpuPaths(), scene, environment);
    const std::vector<output::FrameOutput> some = tiles.render(cameras, settings);
    const std::vector<output::FrameOutput> every = all.render(cameras, settings);
    for (size_t i = 0; i < cameras.size(); ++i) {
      SCOPED_TRACE(fmt::format("view {}", i));
      expectEqualBytes(some[i], every[i]);
    }
  }

  static Settings settingsFor(const PictureSize& size, const char* lighting = "clustered") {
    Settings settings = settingsOf(size.width, size.height, kPackedOutputs);
    settings.display = true;
    settings.lighting = &findTechnique(lighting);
    return settings;
  }
};

TEST_F(CoveredTiles, PicturesOfAnySizeAreTheSame) {
  for (const PictureSize& size : kPictureSizes) {
    SCOPED_TRACE(fmt::format("{}x{}", size.width, size.height));
    for (const float half : {0.4f, 5.0f}) compare(threeSquares(half, false), settingsFor(size));  // in part, and filled
  }
}

TEST_F(CoveredTiles, EachPixelIsFound) {
  constexpr int kWidth = 17, kHeight = 9;  // a tile of 16x8 and a pixel more
  constexpr float kPixel = 2.0f / kHeight;
  scene::SceneBuilder builder("pixel");
  builder.scene.meshes = {squareMesh()};
  builder.scene.materials = {scene::plainMaterial("m", {0.8f, 0.5f, 0.3f}, 0.2f, 0.4f)};
  builder.addInstance("square", builder.kRoot, 0, 0, glm::scale(glm::mat4(1), glm::vec3(0.45f * kPixel)));
  std::vector<scene::Camera> cameras;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      scene::Camera& camera = cameras.emplace_back(frontCamera());
      camera.toWorld[3].x -= kPixel * static_cast<float>(x - kWidth / 2);
      camera.toWorld[3].z += kPixel * static_cast<float>(y - kHeight / 2);
    }
  Settings settings = settingsOf(kWidth, kHeight, {Aov::Depth, Aov::Id});
  const std::vector<output::FrameOutput> views = Renderer(device(), builder.scene, nullptr).render(cameras, settings);
  for (size_t i = 0; i < views.size(); ++i) {
    const std::vector<uint32_t>& ids = views[i].aovs[1].ids;
    EXPECT_NE(ids[i], 0u) << "pixel " << i;
    EXPECT_EQ(std::ranges::count(ids, 0u), std::ssize(ids) - 1) << "pixel " << i;
  }
}

TEST_F(CoveredTiles, BlendedSurfacesAreVisibleOutsideOfThem) {
  for (const PictureSize& size : kPictureSizes) compare(threeSquares(0.4f, true), settingsFor(size));
}

TEST_F(CoveredTiles, BackgroundsAreDrawnOutsideOfThem) {
  Settings settings = settingsFor({97, 43});
  for (const Background::Kind kind : {Background::Color, Background::Environment}) {
    settings.background = {.kind = kind, .color = {0.2f, 0.4f, 0.6f}};
    compare(threeSquares(0.4f, false), settings);
  }
}

TEST_F(CoveredTiles, SettingsThatChangeOtherPixelsAreTheSame) {
  const std::vector<std::pair<const char*, std::function<void(Settings&)>>> changes = {
      {"fog", [](Settings& s) { s.fogDensity = 0.2f; }},
      {"bloom", [](Settings& s) { s.bloom = 0.3f; }},
      {"fxaa", [](Settings& s) { s.aa.fxaa = true; }},
      {"ss2", [](Settings& s) { s.aa.superSampling = 2; }},
      {"msaa4", [](Settings& s) { s.aa.samples = 4; }},
      {"other axes", [](Settings& s) { s.axes = Axes::ZUp; }},
      {"camera normals", [](Settings& s) { s.normalFrame = NormalFrame::OpenCv; }},
      {"positions", [](Settings& s) { s.aovs = {Aov::Position}; }},
      {"depth", [](Settings& s) { s.aovs = {Aov::Depth}; }},
      {"counts",
       [](Settings& s) {
         s.aovs = {Aov::LightsUsed, Aov::Samples, Aov::Depth};
       }},
      {"a tone map", [](Settings& s) { s.tonemap = Tonemap::Aces; }}};
  for (const auto& [name, change] : changes) {
    SCOPED_TRACE(name);
    Settings settings = settingsFor({97, 43});
    change(settings);
    compare(threeSquares(0.4f, false), settings);
  }
}

TEST_F(CoveredTiles, TechniquesAndLayoutsAreTheSame) {
  for (const char* lighting : {"fullscreen", "tiled"})
    compare(threeSquares(0.4f, false), settingsFor({97, 43}, lighting));
  for (const Layout* layout : layoutsToMeet()) {
    SCOPED_TRACE(layout->name);
    Settings settings = settingsFor({97, 43});
    settings.layout = layout;
    compare(threeSquares(0.4f, false), settings);
  }
}

}  // namespace
}  // namespace latelight::render::test
