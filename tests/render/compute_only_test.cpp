// Frames without a graphics pipeline: on a device that is used only for compute, creating one is an error.
#include <memory>

#include "base/error.h"
#include "models/models.h"
#include "output/aov.h"
#include "render/submit/raster_choice.h"
#include "render/support.h"
#include "scene/lens.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using output::Aov;

class ComputeOnly : public RenderTest {
 protected:
  // A device whose queue supports only compute, if the hardware has such a queue.
  static vk::Device& computeDevice() { return *computeDevice_; }
  static void SetUpTestSuite() {
    const std::string selector = std::to_string(device().info().index);
    computeDevice_ =
        std::make_unique<vk::Device>(vk::DeviceOptions{.selector = selector, .validation = true, .graphics = false});
  }
  static void TearDownTestSuite() { computeDevice_.reset(); }
  void TearDown() override {
    RenderTest::TearDown();
    for (const std::string& message : computeDevice().validationMessages()) ADD_FAILURE() << message;
  }
  static Settings settings() {
    Settings s = settingsOf(64, 48, {Aov::Color, Aov::Depth, Aov::Part, Aov::Normal, Aov::Motion, Aov::LightsUsed});
    s.raster = Raster::Compute;
    s.display = true;
    s.shadows = ShadowFormat::D32;
    return s;
  }
  // Expects the same bytes as on a device with graphics.
  static void expectAlike(const scene::Scene& scene, const Settings& s) {
    const scene::Camera camera = cameraOf(scene, s.width, s.height);
    const output::FrameOutput frame = renderOne(computeDevice(), scene, camera, s);
    const output::FrameOutput other = renderOne(device(), scene, camera, s);
    EXPECT_EQ(frame.display, other.display);
    for (const Aov aov : s.aovs) {
      EXPECT_EQ(imageOf(frame, aov).ids, imageOf(other, aov).ids) << output::info(aov).name;
      EXPECT_EQ(imageOf(frame, aov).values, imageOf(other, aov).values) << output::info(aov).name;
    }
  }

 private:
  static inline std::unique_ptr<vk::Device> computeDevice_;
};

TEST_F(ComputeOnly, HasNoGraphics) {
  EXPECT_TRUE(device().hasGraphics());
  EXPECT_FALSE(computeDevice().hasGraphics());
}

// Each technique that supports compute, with a different method for glass, different shadows and different effects.
TEST_F(ComputeOnly, EveryTechniqueGlassShadowAndEffect) {
  const scene::Scene glass = scene::load("builtin:hall,triangles=50k,lights=20,glass=1");
  const TransparencyMethod methods[] = {TransparencyMethod::Exact, TransparencyMethod::Sorted,
                                        TransparencyMethod::Weighted};
  const ShadowFormat formats[] = {ShadowFormat::D32, ShadowFormat::D16, ShadowFormat::Rgba8};
  size_t turn = 0;
  for (const TechniqueInfo& technique : techniques()) {
    if (technique.forward || technique.name == "volumes") continue;
    SCOPED_TRACE(technique.name);
    Settings s = settings();
    s.lighting = &technique;
    s.transparency = methods[turn % 3];
    s.shadows = formats[turn % 3];
    if (turn % 3 == 1) {
      s.shadowFilter = ShadowFilter::Pcss;
      s.fogDensity = 0.05f;
      s.bloom = 0.1f;
      s.sun = SunLight{.azimuth = 0.6f, .elevation = 0.8f, .illuminance = 5};
    }
    if (turn % 3 == 2) {
      s.dataSurfaces = DataSurfaces::Any;
      s.aa.fxaa = true;
    }
    expectAlike(glass, s);
    ++turn;
  }
  EXPECT_GE(turn, 3u);
}

// Other tests cover the default layout and `exact`, which data outputs use. This test adds a layout with targets and
// the only one without targets. The remaining layouts share the path of the first, and on a device with graphics each
// layout is compared with hardware. One model has alpha masks, the other one moves.
TEST_F(ComputeOnly, LayoutsAndModelsOfEachKind) {
  for (const auto& [model, layout] : {std::pair{"textured.glb", "battlefield3"}, {"intricate.glb", "visibility"}}) {
    SCOPED_TRACE(layout);
    Settings s = settings();
    s.lighting = &findTechnique("clustered");
    s.layout = &findLayout(layout);
    expectAlike(scene::load(models::modelPath(model).string()), s);
  }
}

TEST_F(ComputeOnly, SeveralSamplesPerPixel) {
  Settings s = settings();
  s.aovs.push_back(Aov::Samples);
  s.fogDensity = 0.05f;
  s.ambientOcclusion = AmbientOcclusion::Gtao;
  s.lighting = &findTechnique("clustered");
  s.aa.samples = 4;  // a number that graphics pipelines support too
  expectAlike(scene::load(models::modelPath("textured.glb").string()), s);  // with an alpha mask
  expectAlike(scene::load("builtin:hall,triangles=50k,lights=20,glass=1"), s);
}

// Each is rejected with one sentence, before anything is built.
TEST_F(ComputeOnly, SettingsThatRequireGraphicsAreRejected) {
  Settings hardware = settings(), forward = settings(), volumes = settings(), samples = settings();
  hardware.raster = Raster::Hardware;
  forward.lighting = &findTechnique("forward");
  volumes.lighting = &findTechnique("volumes");
  samples.lighting = volumes.lighting;
  samples.aa.samples = 4;
  const scene::Camera camera = cameraOf(hall(), 64, 48);
  for (const Settings& s : {hardware, forward, volumes, samples}) {
    try {
      renderOne(computeDevice(), hall(), camera, s);
      FAIL() << "something was drawn";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::NoDevice);
      EXPECT_NE(std::string(error.what()).find("graphics pipeline"), std::string::npos) << error.what();
    }
  }
}

// --- auto -----------------------------------------------------------------------------------------------------------

TEST_F(ComputeOnly, AutoChoosesARasterThatTheDeviceSupports) {
  Settings s;
  s.raster = Raster::Auto;
  EXPECT_EQ(chooseRaster(computeDevice(), s, hall()).raster, Raster::Compute);
  const RasterChoice choice = chooseRaster(device(), s, hall());
  EXPECT_NE(choice.raster, Raster::Auto);
  EXPECT_EQ(chooseRaster(device(), s, hall()).why, choice.why);  // measured only once
  s.aa.samples = 8;
  // The graphics pipeline does not support this number of samples.
  EXPECT_EQ(chooseRaster(device(), s, hall()).raster, Raster::Compute);
  s.aa.samples = 1;
  s.lighting = &findTechnique("forward");
  EXPECT_EQ(chooseRaster(device(), s, hall()).raster, Raster::Hardware);
  s.raster = Raster::Compute;
  EXPECT_EQ(chooseRaster(device(), s, hall()).raster, Raster::Compute);  // as requested
}

TEST_F(ComputeOnly, KnowsTheRastersThatFramesMayHave) {
  using Rasters = std::vector<Raster>;
  scene::Camera camera = cameraOf(hall(), 64, 48);
  const auto rasters = [&](const Settings& s, const vk::Device& on) { return possibleRasters(on, s, {&camera, 1}); };
  const auto settings = [](Raster raster, const char* lighting = "clustered", uint32_t samples = 1) {
    Settings s;
    s.raster = raster;
    s.lighting = &findTechnique(lighting);
    s.aa.samples = samples;
    return s;
  };
  EXPECT_EQ(rasters(settings(Raster::Auto), device()), (Rasters{Raster::Hardware, Raster::Compute}));
  EXPECT_EQ(rasters(settings(Raster::Auto), computeDevice()), Rasters{Raster::Compute});
  for (const Raster raster : {Raster::Auto, Raster::Hardware, Raster::Compute}) {
    EXPECT_EQ(rasters(settings(raster, "forward"), device()), Rasters{Raster::Hardware});
    EXPECT_EQ(rasters(settings(raster, "volumes", 4), device()), Rasters{Raster::Hardware});
    EXPECT_EQ(rasters(settings(raster, "clustered", 8), device()), Rasters{Raster::Compute});
  }
  for (const Raster raster : {Raster::Hardware, Raster::Compute, Raster::Rays})
    EXPECT_EQ(rasters(settings(raster), device()), Rasters{raster});
  camera.lens = scene::parseLens("--lens", "equirectangular", 64, 48);
  EXPECT_EQ(rasters(settings(Raster::Auto), device()), Rasters{Raster::Compute});
  EXPECT_EQ(rasters(settings(Raster::Hardware, "clustered", 4), device()), Rasters{Raster::Compute});
  EXPECT_EQ(rasters(settings(Raster::Rays), device()), Rasters{Raster::Rays});
}

// If compute shaders must filter textures themselves, they become faster only with many triangles. The more pixels show
// materials, the more triangles are required.
TEST_F(ComputeOnly, AutoDependsOnTheSceneWithoutDescriptorIndexing) {
  if (device().maxTextureArray() != 0) GTEST_SKIP() << "this device has descriptor indexing";
  scene::Scene scene;
  scene.meshes.emplace_back().indices.resize(3 * 100'000);
  Settings data, picture;
  data.display = false;
  data.aovs = {Aov::Depth, Aov::Id};
  for (Settings* s : {&data, &picture}) s->width = s->height = 1000;
  const auto minInstancesForCompute = [&](const Settings& s) {  // number of instances with 100,000 triangles each
    scene.instances.clear();
    while (chooseRaster(device(), s, scene).raster == Raster::Hardware) {
      scene.instances.push_back({});
      if (scene.instances.size() > 100) break;
    }
    return scene.instances.size();
  };
  const size_t dataInstances = minInstancesForCompute(data), imageInstances = minInstancesForCompute(picture);
  EXPECT_LT(dataInstances, imageInstances) << "textures to filter";
  scene.instances.back().removed = true;
  EXPECT_EQ(chooseRaster(device(), picture, scene).raster, Raster::Hardware) << "what was removed does not count";
  data.aa.samples = picture.aa.samples = 4;
  EXPECT_EQ(minInstancesForCompute(data), dataInstances) << "data have one sample a pixel";
  EXPECT_LT(minInstancesForCompute(picture), imageInstances) << "more samples to draw, of few surfaces";
  data.width = 5000;
  picture.aa.samples = 1;
  picture.width = 5000;
  EXPECT_EQ(minInstancesForCompute(data), dataInstances) << "no textures to filter";
  EXPECT_GT(minInstancesForCompute(picture), imageInstances + 5) << "more pixels";
}

// Calls of worlds repeat, so the time to create more pipelines does not count.
TEST_F(ComputeOnly, AutoChoosesComputeForSmallImagesOfWorldsWithoutDescriptorIndexing) {
  if (device().maxTextureArray() != 0) GTEST_SKIP() << "this device has descriptor indexing";
  scene::Scene scene;
  scene.meshes.emplace_back().indices.resize(3 * 10'000);
  scene.instances.push_back({});
  Settings picture;
  picture.raster = Raster::Auto;
  picture.width = picture.height = 64;
  EXPECT_EQ(chooseRaster(device(), picture, scene).raster, Raster::Hardware);
  EXPECT_EQ(chooseRaster(device(), picture, scene, RasterUse::Worlds).raster, Raster::Compute);
  picture.width = picture.height = 256;
  EXPECT_EQ(chooseRaster(device(), picture, scene, RasterUse::Worlds).raster, Raster::Hardware);
  Settings data = picture;
  data.display = false;
  data.aovs = {Aov::Depth, Aov::Id};
  EXPECT_EQ(chooseRaster(device(), data, scene, RasterUse::Worlds).raster, Raster::Compute);
}

}  // namespace
}  // namespace latelight::render::test
