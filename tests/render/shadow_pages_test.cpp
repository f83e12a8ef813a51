// Virtual shadow maps, which render only the pages that pixels look up: images equal those of complete maps, to the
// byte.
#include <bit>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "render/base/readback.h"
#include "render/shadow/page_push.h"
#include "render/shadow/pages.h"
#include "render/support.h"
#include "scene/edit.h"
#include "scene/load/load.h"
#include "shared/light.h"

namespace latelight::render::test {
namespace {

using glm::mat4;
using glm::vec3;
using output::Aov;

// Balls and boards scattered over a floor, lit by a sun, spot lights and point lights; in glTF's frame.
struct Strewn {
  std::mt19937 random;
  scene::SceneBuilder builder{"strewn"};
  scene::Scene& scene = builder.scene;

  explicit Strewn(uint32_t seed) : random(seed) {
    scene.meshes = {sphereMesh(0.5f), squareMesh()};
    scene.materials = {scene::plainMaterial("plain", vec3(0.8f), 0, 1)};
    for (uint32_t i = 0; i < 30; ++i) builder.addInstance("thing", builder.kRoot, i % 2, 0, placed());
    const mat4 flat = glm::rotate(glm::translate(mat4(1), vec3(0, -1, 0)), -1.5707964f, vec3(1, 0, 0));
    builder.addInstance("floor", builder.kRoot, 1, 0, glm::scale(flat, vec3(14)));
    addLight(shared::kLightDirectional, 2, 0.05f);
    for (uint32_t i = 0; i < 2; ++i) addLight(shared::kLightSpot, 60, 0.2f);
    for (uint32_t i = 0; i < 3; ++i) addLight(shared::kLightPoint, 30, 0.1f);
  }

  float in(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); }
  vec3 somewhere() { return {in(-8, 8), in(-0.5f, 2), in(-8, 8)}; }
  mat4 placed() {
    const mat4 turned = glm::rotate(glm::translate(mat4(1), somewhere()), in(0, 6), glm::normalize(somewhere()));
    return glm::scale(turned, vec3(in(0.4f, 1.2f)));
  }
  void addLight(uint32_t type, float intensity, float size) {
    scene::Light light{.type = type, .intensity = intensity};
    light.position = somewhere() + vec3(0, 2, 0);
    light.direction = glm::normalize(vec3(in(-1, 1), -1, in(-1, 1)));
    if (type != shared::kLightDirectional) light.range = in(5, 12);
    light.size = size;
    scene.lights.push_back(light);
  }
  scene::Camera camera() {
    scene::Camera camera = frontPerspective(in(0.2f, 0.9f), 6);
    camera.toWorld = glm::dmat4(glm::rotate(mat4(1), in(-0.6f, 0.6f), vec3(0, 1, 0)) *
                                glm::translate(mat4(1), vec3(in(-3, 3), in(0, 1), in(-2, 4)))) *
                     camera.toWorld;
    return camera;
  }
};

Settings pagedSettings(ShadowFormat format, ShadowFilter filter) {
  Settings settings = settingsOf(448, 64, {Aov::Color});
  settings.raster = Raster::Compute;
  settings.shadows = format;
  settings.shadowFilter = filter;
  return settings;
}

struct PageCount {
  uint64_t drawn = 0, all = 0;
};

class ShadowPagesTest : public RenderTest {
 protected:
  struct Both {
    Renderer paged, whole;
    explicit Both(const scene::Scene& scene) : paged(device(), scene, nullptr), whole(device(), scene, nullptr) {}
  };

  // Counts the pages of the maps that a renderer caches.
  static PageCount pagesOf(const Renderer& renderer) {
    const ShadowMapCache& kept = renderer.shadowMaps();
    graph::Executor executor(device());
    graph::Graph graph(executor);
    const graph::BufferId words = graph.import(*kept.pages(), graph::Use::StorageReadWrite);
    const graph::BufferId host = copyToHost({device(), graph}, graph::Stage::Output, "pages", {words}).front();
    const graph::Submission& done = executor.run(graph, graph.compile());
    const vk::ImageDesc& atlas = kept.atlas()->desc();
    PageCount count;
    for (const AtlasTile& tile : kept.tiles()) {
      const uint32_t rows = std::max(tile.size / shared::kShadowPage, 1u);
      for (uint32_t row = 0; row < rows; ++row)
        count.drawn += static_cast<uint64_t>(
            std::popcount(done.buffer(host).as<uint32_t>()[firstPageWord(atlas, tile) + row * pageWordStep(atlas)]));
      count.all += uint64_t{rows} * rows;
    }
    return count;
  }

  // Expects the images of complete maps, and returns the statistics of the paged render.
  static RenderStatistics expectSame(Both& both, std::span<const scene::Camera> cameras, Settings settings) {
    RenderResult result = both.paged.submit(cameras, settings).take();
    const std::vector<output::FrameOutput>& paged = result.frames;
    settings.wholeShadowMaps = true;
    const std::vector<output::FrameOutput> whole = both.whole.render(cameras, settings);
    for (size_t i = 0; i < cameras.size(); ++i)
      EXPECT_TRUE(imageOf(paged[i], Aov::Color).values == imageOf(whole[i], Aov::Color).values) << "view " << i;
    const PageCount all = pagesOf(both.whole);
    EXPECT_EQ(all.drawn, all.all);
    return std::move(result.statistics);
  }
};

// The camera and an instance move between frames, so pages are added to cached maps.
TEST_F(ShadowPagesTest, EveryFormatAndFilter) {
  const std::pair<ShadowFormat, ShadowFilter> kinds[] = {{ShadowFormat::D32, ShadowFilter::Pcf},
                                                         {ShadowFormat::D16, ShadowFilter::Hard},
                                                         {ShadowFormat::Rgba8, ShadowFilter::Pcss},
                                                         {ShadowFormat::Rgba8Classic, ShadowFilter::Pcf}};
  const char* layouts[] = {"plain", "killzone2", "optimized", "blog"};
  for (uint32_t kind = 0; kind < 4; ++kind) {
    SCOPED_TRACE(kind);
    Strewn strewn(kind);
    Settings settings = pagedSettings(kinds[kind].first, kinds[kind].second);
    settings.layout = &findLayout(layouts[kind]);
    Both both(strewn.scene);
    scene::Camera camera = strewn.camera();
    for (uint32_t frame = 0; frame < 2; ++frame) {
      expectSame(both, {&camera, 1}, settings);
      const PageCount pages = pagesOf(both.paged);
      EXPECT_GT(pages.drawn, 0u);
      EXPECT_LT(pages.drawn, pages.all) << "frame " << frame;
      camera = strewn.camera();
      if (frame == 0) scene::setTransform(strewn.scene, 3, strewn.placed());
    }
  }
}

// After several frames have looked up a map that does not change, the map is drawn completely, and frames no longer
// search for pages.
TEST_F(ShadowPagesTest, UnchangedMapsBecomeComplete) {
  Strewn strewn(7);
  const Settings settings = pagedSettings(ShadowFormat::D32, ShadowFilter::Pcf);
  Both both(strewn.scene);
  const scene::Camera camera = strewn.camera();
  const auto draws = [&] {
    const RenderStatistics statistics = expectSame(both, {&camera, 1}, settings);
    return std::ranges::any_of(statistics.passTimes, [](const auto& time) { return time.name == "shadow maps"; });
  };
  for (uint32_t frame = 0; frame < 4; ++frame) EXPECT_TRUE(draws());
  EXPECT_EQ(pagesOf(both.paged).drawn, pagesOf(both.paged).all);
  EXPECT_FALSE(draws());
}

// The samples of an image and its strips are separate graphs, which add pages to the same maps; the views of one graph
// share maps.
TEST_F(ShadowPagesTest, SamplesStripsAndViews) {
  Strewn strewn(11);
  const std::vector<scene::Camera> cameras{strewn.camera(), strewn.camera(), strewn.camera()};
  const auto with = [&](auto change) {
    Settings settings = pagedSettings(ShadowFormat::D32, ShadowFilter::Pcf);
    change(settings);
    return settings;
  };
  Both both(strewn.scene);
  expectSame(both, cameras, with([](Settings&) {}));
  const PageCount pages = pagesOf(both.paged);
  EXPECT_LT(pages.drawn, pages.all);
  for (uint32_t kind = 0; kind < 4; ++kind) {
    SCOPED_TRACE(kind);
    Both fresh(strewn.scene);
    expectSame(fresh, std::span(cameras).subspan(kind % 3, 1), with([&](Settings& s) {
                 if (kind == 0) s.aa.samples = 4;
                 if (kind == 1) s.aa.superSampling = 2;
                 if (kind == 2) s.stripPixels = 448 * 16;
                 if (kind == 3) s.lighting = &findTechnique("clustered"), s.aa.temporal = true;
               }));
  }
}

// Surfaces that are shaded outside the G-buffer require complete maps; views through a lens look up pages.
TEST_F(ShadowPagesTest, GlassAndLenses) {
  Strewn strewn(13);
  strewn.scene.materials.push_back(strewn.scene.materials.front());
  strewn.scene.materials.back().data.flags |= shared::kMaterialBlended;
  strewn.scene.materials.back().data.baseColor.a = 0.5f;
  const Settings settings = pagedSettings(ShadowFormat::D32, ShadowFilter::Pcf);
  scene::Camera camera = strewn.camera();
  {
    Both both(strewn.scene);
    camera.lens = scene::Lens{scene::LensModel::OpenCv, 448, 64, 300, 300, 224, 32};
    expectSame(both, {&camera, 1}, settings);
    EXPECT_LT(pagesOf(both.paged).drawn, pagesOf(both.paged).all);
    camera.lens.reset();
  }
  for (uint32_t i = 0; i < 4; ++i) strewn.builder.addInstance("glass", strewn.builder.kRoot, 0, 1, strewn.placed());
  Both both(strewn.scene);
  expectSame(both, {&camera, 1}, settings);
  EXPECT_EQ(pagesOf(both.paged).drawn, pagesOf(both.paged).all);
}

// Hundreds of maps, and queues without enough capacity at first: missing maps are drawn again.
TEST_F(ShadowPagesTest, AllLightsOfTheHall) {
  const scene::Scene scene = scene::load("builtin:hall,triangles=50k,lights=24");
  Settings settings = pagedSettings(ShadowFormat::D32, ShadowFilter::Pcf);
  settings.shadowLights = readText<ShadowLights>("--shadow-lights", "all");
  settings.shadowAtlas = 1024;
  Both both(scene);
  scene::Camera camera = cameraOf(scene, 448, 64);
  expectSame(both, {&camera, 1}, settings);
  EXPECT_LT(pagesOf(both.paged).drawn, pagesOf(both.paged).all);
}

}  // namespace
}  // namespace latelight::render::test
