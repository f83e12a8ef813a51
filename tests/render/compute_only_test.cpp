// Frames without a graphics pipeline: on a device that is used only for compute, creating one is an error.
#include <memory>

#include "base/error.h"
#include "models/models.h"
#include "output/aov.h"
#include "render/submit/raster_choice.h"
#include "render/support.h"
#include "scene/load/load.h"

namespace latelight::render::test {
namespace {

using output::Aov;

class ComputeOnly : public RenderTest {
 protected:
  // On a queue for compute alone, where the device has one.
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
  // The same bytes as on a device that could draw.
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

// Each technique that computes with another method for glass, and other shadows and effects.
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

// Beside the default, with which the other tests render, and `exact`, which data outputs take: one that has targets,
// and the one that has none. The others go the same way, and on a device with graphics every one is compared with
// hardware. One model has masks, the other moves.
TEST_F(ComputeOnly, LayoutsAndModelsOfEachKind) {
  for (const auto& [model, layout] : {std::pair{"textured.glb", "battlefield3"}, {"intricate.glb", "visibility"}}) {
    SCOPED_TRACE(layout);
    Settings s = settings();
    s.lighting = &findTechnique("clustered");
    s.layout = &findLayout(layout);
    expectAlike(scene::load(models::modelPath(model).string()), s);
  }
}

TEST_F(ComputeOnly, SeveralSamplesAPixel) {
  Settings s = settings();
  s.aovs.push_back(Aov::Samples);
  s.fogDensity = 0.05f;
  s.ambientOcclusion = AmbientOcclusion::Gtao;
  s.lighting = &findTechnique("clustered");
  s.aa.samples = 4;                                                         // as many as hardware could have
  expectAlike(scene::load(models::modelPath("textured.glb").string()), s);  // with a mask
  expectAlike(scene::load("builtin:hall,triangles=50k,lights=20,glass=1"), s);
}

// Each is refused in a sentence, before anything is built.
TEST_F(ComputeOnly, WhatDrawsIsRefused) {
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

TEST_F(ComputeOnly, AutoIsWhatTheDeviceCanDo) {
  Settings s;
  s.raster = Raster::Auto;
  EXPECT_EQ(chooseRaster(computeDevice(), s, hall()).raster, Raster::Compute);
  const RasterChoice choice = chooseRaster(device(), s, hall());
  EXPECT_NE(choice.raster, Raster::Auto);
  EXPECT_EQ(chooseRaster(device(), s, hall()).why, choice.why);  // measured once
  s.aa.samples = 8;
  EXPECT_EQ(chooseRaster(device(), s, hall()).raster, Raster::Compute);  // hardware has no such number
  s.aa.samples = 1;
  s.lighting = &findTechnique("forward");
  EXPECT_EQ(chooseRaster(device(), s, hall()).raster, Raster::Hardware);
  s.raster = Raster::Compute;
  EXPECT_EQ(chooseRaster(device(), s, hall()).raster, Raster::Compute);  // as asked
}

// Where compute shaders have to filter textures themselves, they pay once there are many triangles: the more pixels
// show materials, the later.
TEST_F(ComputeOnly, AutoDependsOnTheSceneWithoutDescriptorIndexing) {
  if (device().maxTextureArray() != 0) GTEST_SKIP() << "this device has descriptor indexing";
  scene::Scene scene;
  scene.meshes.emplace_back().indices.resize(3 * 1'000'000);
  Settings data, picture;
  data.display = false;
  data.aovs = {Aov::Depth, Aov::Id};
  for (Settings* s : {&data, &picture}) s->width = s->height = 1000;
  const auto fewestForCompute = [&](const Settings& s) {  // instances, of a million triangles each
    scene.instances.clear();
    while (chooseRaster(device(), s, scene).raster == Raster::Hardware) {
      scene.instances.push_back({});
      if (scene.instances.size() > 100) break;
    }
    return scene.instances.size();
  };
  const size_t ofData = fewestForCompute(data), ofPicture = fewestForCompute(picture);
  EXPECT_LT(ofData, ofPicture) << "textures to filter";
  scene.instances.back().removed = true;
  EXPECT_EQ(chooseRaster(device(), picture, scene).raster, Raster::Hardware) << "what was removed does not count";
  data.aa.samples = picture.aa.samples = 4;
  EXPECT_EQ(fewestForCompute(data), ofData) << "data have one sample a pixel";
  EXPECT_LT(fewestForCompute(picture), ofPicture) << "more samples to draw, of few surfaces";
  data.width = 5000;
  picture.aa.samples = 1;
  picture.width = 5000;
  EXPECT_EQ(fewestForCompute(data), ofData) << "no textures to filter";
  EXPECT_GT(fewestForCompute(picture), ofPicture + 5) << "more pixels";
}

}  // namespace
}  // namespace latelight::render::test
