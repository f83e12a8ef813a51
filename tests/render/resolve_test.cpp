// On a CPU device, materials of small triangles are evaluated once per pixel, by texture group (visibility/resolve.h).
// The code paths for GPUs, on the same device, show the same surfaces: the geometry pass's fragment shaders, and
// textures that compute shaders filter.
#include "render/visibility/resolve.h"

#include <fmt/core.h>

#include <algorithm>

#include "render/support.h"
#include "scene/edit.h"

namespace latelight::render::test {
namespace {

using glm::u8vec4;
using output::Aov;
using shared::kTextureBaseColor, shared::kTextureNormal;

// More outputs than a pass packs, with constant and with view-dependent backgrounds.
const std::vector<Aov> kFieldOutputs = {Aov::Color,     Aov::Depth,  Aov::Id,       Aov::Material,
                                        Aov::Normal,    Aov::Albedo, Aov::Position, Aov::Roughness,
                                        Aov::GeoNormal, Aov::Uv,     Aov::Triangle};
constexpr uint32_t kFieldWidth = 117, kFieldHeight = 67;  // neither a multiple of a tile's size
constexpr int kAlong = 12;                                // squares per row and column

scene::Texture gradient(u8vec4 from, u8vec4 to, bool srgb) {
  constexpr uint32_t kSide = 16;
  std::vector<u8vec4> texels;
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x)
      texels.emplace_back(glm::mix(glm::vec4(from), glm::vec4(to), float(x + y) / float(2 * kSide - 2)));
  return textureOf(kSide, kSide, srgb, texels);
}

// A field of small squares of four materials: without textures, with a base color, with that and a normal map, and with
// holes. The squares leave gaps between them, and every second one lies deeper.
scene::Scene field() {
  scene::SceneBuilder builder("field");
  scene::Scene& scene = builder.scene;
  scene.meshes = {squareMesh(true)};
  scene.textures = {gradient({255, 40, 20, 255}, {20, 60, 250, 255}, true),
                    gradient({100, 140, 255, 255}, {150, 110, 255, 255}, false),
                    gradient({30, 200, 90, 0}, {30, 90, 200, 255}, true)};
  for (const float roughness : {0.2f, 0.4f, 0.6f, 0.8f})
    scene.materials.push_back(scene::plainMaterial("m", {0.9f, 0.8f, 0.7f}, 0.3f, roughness));
  setTexture(scene.materials[1], kTextureBaseColor, 0);
  setTexture(scene.materials[2], kTextureBaseColor, 0);
  setTexture(scene.materials[2], kTextureNormal, 1);
  setTexture(scene.materials[3], kTextureBaseColor, 2);
  scene.materials[3].data.flags |= shared::kMaterialMasked;
  scene.materials[3].data.alphaCutoff = 0.5f;
  for (int y = 0; y < kAlong; ++y)
    for (int x = 0; x < kAlong; ++x) {
      const glm::vec3 at((2 * x + 1) / float(kAlong) - 1, (2 * y + 1) / float(kAlong) - 1, (x + y) % 2 ? 0 : -0.5f);
      const glm::mat4 turned = glm::rotate(glm::translate(glm::mat4(1), 0.8f * at), 0.3f * float(x - y), {0, 1, 0});
      builder.addInstance("square", builder.kRoot, 0, static_cast<uint32_t>(x + 3 * y) % 4,
                          glm::scale(turned, glm::vec3(0.7f / kAlong)));
    }
  scene::Light& light = scene.lights.emplace_back();
  light.type = shared::kLightPoint;
  light.position = {0.3f, -1, 1.4f};
  light.intensity = 6;
  return std::move(scene);
}

Settings fieldSettings(Raster raster, std::vector<Aov> aovs = kFieldOutputs) {
  Settings settings = settingsOf(kFieldWidth, kFieldHeight, std::move(aovs));
  settings.raster = raster;
  return settings;
}

RenderResult resultOf(Renderer& renderer, const Settings& settings, std::vector<scene::Camera> cameras) {
  return renderer.submit(cameras, settings, {}, Results::ToHost).take();
}

bool resolvesGroups(const RenderResult& result) {
  return std::ranges::count(result.statistics.passTimes, "tiles of texture groups", &graph::PassTime::name) > 0;
}

// Returns the largest difference of two outputs' values.
float largestDifference(const output::FrameOutput& a, const output::FrameOutput& b, Aov aov) {
  const std::vector<float>&x = imageOf(a, aov).values, &y = imageOf(b, aov).values;
  float largest = 0;
  EXPECT_EQ(x.size(), y.size());
  for (size_t i = 0; i < x.size(); ++i)
    if (x[i] != y[i]) largest = std::max(largest, std::abs(x[i] - y[i]));  // equal: also infinities
  return largest;
}

// lavapipe filters in 8 bits and chooses levels per quad in fragment shaders, and in floats and per pixel elsewhere.
constexpr float kFilterTolerance = 0.03f;

void expectSameSurfaces(const output::FrameOutput& a, const output::FrameOutput& b) {
  for (const Aov aov : {Aov::Id, Aov::Material, Aov::Triangle})
    EXPECT_TRUE(imageOf(a, aov).ids == imageOf(b, aov).ids) << output::info(aov).name;
  EXPECT_EQ(largestDifference(a, b, Aov::Depth), 0);
  EXPECT_EQ(largestDifference(a, b, Aov::Roughness), 0);
  for (const Aov aov : {Aov::Position, Aov::Uv, Aov::GeoNormal})
    EXPECT_LT(largestDifference(a, b, aov), 2e-5f) << output::info(aov).name;
  for (const Aov aov : {Aov::Albedo, Aov::Normal})
    EXPECT_LT(largestDifference(a, b, aov), kFilterTolerance) << output::info(aov).name;
}

class TextureGroups : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (!device().hasCpuShaders() || device().maxTextureArray() > 0) GTEST_SKIP() << "the device indexes textures";
  }
};

TEST_F(TextureGroups, SurfacesAreThoseOfTheGeometryPass) {
  const scene::Scene scene = field();
  Renderer groups(device(), scene, nullptr), plain(gpuPaths(), scene, nullptr);
  scene::Camera away = frontCamera();
  away.toWorld[3].x += 50;  // sees nothing
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    SCOPED_TRACE(raster == Raster::Hardware ? "hardware" : "compute");
    const Settings settings = fieldSettings(raster);
    const std::vector<scene::Camera> cameras = {frontCamera(), frontPerspective(0.5f, 4), away};
    const RenderResult a = resultOf(groups, settings, cameras), b = resultOf(plain, settings, cameras);
    EXPECT_TRUE(a.statistics.passTimes.empty() || resolvesGroups(a));
    EXPECT_FALSE(resolvesGroups(b));
    for (size_t view = 0; view < cameras.size(); ++view) {
      SCOPED_TRACE(fmt::format("view {}", view));
      expectSameSurfaces(a.frames[view], b.frames[view]);
      EXPECT_LT(largestDifference(a.frames[view], b.frames[view], Aov::Color), 0.1f);
    }
  }
}

TEST_F(TextureGroups, ViewsAndOutputsDoNotChangeEachOther) {
  const scene::Scene scene = field();
  Renderer renderer(device(), scene, nullptr);
  const std::vector<scene::Camera> cameras = {frontCamera(), frontPerspective(0.5f, 4)};
  const RenderResult both = resultOf(renderer, fieldSettings(Raster::Hardware), cameras);
  for (size_t view = 0; view < cameras.size(); ++view) {
    const RenderResult one = resultOf(renderer, fieldSettings(Raster::Hardware), {cameras[view]});
    for (const Aov aov : kFieldOutputs) {
      const RenderResult alone = resultOf(renderer, fieldSettings(Raster::Hardware, {aov}), {cameras[view]});
      SCOPED_TRACE(output::info(aov).name);
      for (const RenderResult* other : {&one, &alone}) {
        EXPECT_TRUE(imageOf(other->frames[0], aov).values == imageOf(both.frames[view], aov).values);
        EXPECT_TRUE(imageOf(other->frames[0], aov).ids == imageOf(both.frames[view], aov).ids);
      }
    }
  }
}

TEST_F(TextureGroups, BothRastersResolveAlike) {
  const scene::Scene scene = field();
  Renderer renderer(device(), scene, nullptr);
  for (const scene::Camera& camera : {frontCamera(), frontPerspective(0.5f, 4)}) {
    const RenderResult a = resultOf(renderer, fieldSettings(Raster::Hardware), {camera}),
                       b = resultOf(renderer, fieldSettings(Raster::Compute), {camera});
    const std::vector<uint32_t>&x = imageOf(a.frames[0], Aov::Triangle).ids,
          &y = imageOf(b.frames[0], Aov::Triangle).ids;
    size_t differ = 0;  // pixels on edges, where the graphics pipeline may decide otherwise
    for (size_t i = 0; i < x.size(); ++i) {
      if (x[i] != y[i]) {
        ++differ;
        continue;
      }
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(vec3At(imageOf(a.frames[0], Aov::Albedo), i)[c], vec3At(imageOf(b.frames[0], Aov::Albedo), i)[c],
                    1e-3f);
    }
    EXPECT_LT(differ, x.size() / 100);
  }
}

TEST_F(TextureGroups, AnisotropicTexturesKeepTheirFilter) {
  const scene::Scene scene = field();
  Renderer groups(device(), scene, nullptr), plain(gpuPaths(), scene, nullptr);
  for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
    Settings settings = fieldSettings(raster);
    settings.anisotropy = 8;
    const RenderResult a = resultOf(groups, settings, {frontPerspective(0.5f, 4)}),
                       b = resultOf(plain, settings, {frontPerspective(0.5f, 4)});
    EXPECT_FALSE(resolvesGroups(a));
    EXPECT_LT(largestDifference(a.frames[0], b.frames[0], Aov::Albedo), 1e-6f);  // sRGB is decoded in other ways
  }
}

TEST_F(TextureGroups, EditsChangeGroups) {
  scene::Scene scene = field();
  Renderer renderer(device(), scene, nullptr);
  const auto expectAsNew = [&] {
    for (const Raster raster : {Raster::Hardware, Raster::Compute}) {
      Renderer fresh(device(), scene, nullptr);
      const RenderResult a = resultOf(renderer, fieldSettings(raster), {frontCamera()}),
                         b = resultOf(fresh, fieldSettings(raster), {frontCamera()});
      EXPECT_EQ(largestDifference(a.frames[0], b.frames[0], Aov::Albedo), 0);
      EXPECT_EQ(largestDifference(a.frames[0], b.frames[0], Aov::Color), 0);
    }
  };
  expectAsNew();
  scene::Material material = scene.materials[0];
  setTexture(material, kTextureBaseColor, 0);  // joins the group of material 1
  setMaterial(scene, 0, material);
  expectAsNew();
  setTexture(material, kTextureBaseColor, 2, kNearest);  // a group of its own
  setMaterial(scene, 0, material);
  expectAsNew();
  scene::setTexture(scene, 0, gradient({10, 250, 10, 255}, {250, 10, 250, 255}, true));
  expectAsNew();
  for (uint32_t i = 0; i < 20; ++i) {  // more groups than are resolved like this
    scene.textures.push_back(gradient({uint8_t(12 * i), 90, 40, 255}, {9, uint8_t(11 * i), 4, 255}, true));
    scene::Material more = scene.materials[1];
    setTexture(more, kTextureBaseColor, static_cast<int>(scene.textures.size()) - 1);
    scene.materials.push_back(more);
  }
  Renderer many(device(), scene, nullptr);
  EXPECT_FALSE(resolvesGroups(resultOf(many, fieldSettings(Raster::Hardware), {frontCamera()})));
}

}  // namespace
}  // namespace latelight::render::test
