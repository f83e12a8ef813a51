// Outputs in device memory, as arrays of all views: they equal the images on the host; their ownership and lifetime.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <latelight/latelight.h>

#include <cstring>
#include <functional>
#include <map>

#include "base/error.h"
#include "edits/workshop.h"
#include "models/models.h"

namespace latelight::render::test {
namespace {

using output::Aov;

const std::byte* bytesOf(const ExportedArray& array) {
  return array.memory->buffer.mapped();
}

// Cameras around the workshop.
std::vector<scene::Camera> camerasAround(size_t count) {
  std::vector<scene::Camera> cameras(count, workshopCamera());
  for (size_t i = 0; i < count; ++i) cameras[i].verticalFov *= 1 - 0.08f * static_cast<float>(i);
  return cameras;
}

class DeviceArraysTest : public RenderTest {
 protected:
  static void compare(const Settings& settings, size_t views) {
    const scene::Scene scene = workshop();
    const scene::Environment sky = constantEnvironment();
    const std::vector<scene::Camera> cameras = camerasAround(views);
    Renderer renderer(device(), scene, &sky);
    const std::vector<output::FrameOutput> expected = renderer.render(cameras, settings);
    const std::vector<ExportedArray> arrays = renderer.submit(cameras, settings, {}, Results::Exported).take().arrays;
    ASSERT_EQ(arrays.size(), settings.aovs.size() + settings.display);
    for (const ExportedArray& array : arrays)
      for (size_t view = 0; view < views; ++view) {
        SCOPED_TRACE(fmt::format("view {} of {}", view, array.aov ? output::info(*array.aov).name : "the picture"));
        expectSame(array, view, expected[view]);
      }
  }

 private:
  static void expectSame(const ExportedArray& array, size_t view, const output::FrameOutput& picture) {
    const size_t bytes = array.viewBytes();
    const auto equals = [&](const auto& values) {
      using Value = std::remove_cvref_t<decltype(values[0])>;
      EXPECT_EQ(array.columns, picture.width);
      EXPECT_EQ(array.rows, picture.height);
      ASSERT_EQ(values.size() * sizeof(Value), bytes);
      EXPECT_EQ(std::memcmp(bytesOf(array) + view * bytes, values.data(), bytes), 0);
    };
    if (!array.aov) return equals(picture.display);
    const output::AovImage& image = *std::ranges::find(picture.aovs, *array.aov, &output::AovImage::aov);
    if (output::holdsIntegers(*array.aov))
      equals(image.ids);
    else
      equals(image.values);
  }
};

Settings oddSettings() {
  Settings settings = workshopSettings();
  settings.width = 37;
  settings.height = 29;
  settings.aovs = {Aov::Color, Aov::Depth, Aov::Normal, Aov::Id, Aov::Motion, Aov::LightsUsed};
  return settings;
}

TEST_F(DeviceArraysTest, HoldWhatPicturesHold) {
  if (!device().isCpu()) GTEST_SKIP() << "the host has no arrays of " << device().info().name;
  for (const AntiAliasing aa : {AntiAliasing{}, {.superSampling = 2}, {.samples = 4}, {.temporal = true}}) {
    Settings settings = oddSettings();
    settings.aa = aa;
    compare(settings, 5);
  }
}

TEST_F(DeviceArraysTest, OfStrips) {
  if (!device().isCpu()) GTEST_SKIP() << "the host has no arrays of " << device().info().name;
  Settings settings = oddSettings();
  settings.height = 200;
  settings.stripPixels = 37 * 70;
  ASSERT_GT(stripsOf(settings).size(), 1u);
  compare(settings, 3);
}

TEST_F(DeviceArraysTest, OfDataAlone) {
  if (!device().isCpu()) GTEST_SKIP() << "the host has no arrays of " << device().info().name;
  Settings settings = oddSettings();
  settings.display = false;
  settings.aovs = {Aov::Depth};
  compare(settings, 2);
}

// More views than one frame accepts.
TEST_F(DeviceArraysTest, OfManyViews) {
  if (!device().isCpu()) GTEST_SKIP() << "the host has no arrays of " << device().info().name;
  Settings settings = oddSettings();
  settings.width = settings.height = 8;
  settings.aovs = {Aov::Depth, Aov::Id};
  compare(settings, 300);
}

// --- through the public API -----------------------------------------------------------------------------------------

struct Shop {
  latelight::Scene scene{models::modelPath("punctual.glb").string()};
  latelight::Camera camera = scene.defaultCamera(1);
  Options options = [] {
    Options options;
    options.width = options.height = 16;
    options.aovs = {"depth"};
    return options;
  }();

  std::map<std::string, DeviceArray> render(latelight::Renderer& renderer) const {
    return renderer.submit({camera}, options, latelight::Results::Arrays).takeArrays();
  }
};

TEST(DeviceArrays, MemoryIsRenderedToAgainOnceNobodyHasIt) {
  const Shop shop;
  latelight::Renderer renderer(shop.scene, "cpu");
  std::map<std::string, DeviceArray> held = shop.render(renderer);
  EXPECT_EQ(held.size(), 2u);
  DeviceArray depth = held.at("depth");
  EXPECT_EQ(depth.shape, (std::array<uint64_t, 4>{1, 16, 16, 1}));
  EXPECT_EQ(depth.element, DeviceArray::Element::Float32);
  EXPECT_EQ(held.at("rgba").element, DeviceArray::Element::Uint8);
  const void* first = depth.host();
  const auto import = std::make_shared<int>(7);
  int calls = 0;
  depth.attach(import);
  EXPECT_EQ(held.at("depth").attached(), import) << "copies share the memory";
  depth.beforeReuse([&] { ++calls; });
  EXPECT_NE(shop.render(renderer).at("depth").host(), first) << "somebody has it";
  held.clear();
  EXPECT_NE(shop.render(renderer).at("depth").host(), first) << "a copy still has it";
  EXPECT_EQ(calls, 0);
  depth = {};
  const auto one = shop.render(renderer), two = shop.render(renderer);
  EXPECT_TRUE(one.at("depth").host() == first || two.at("depth").host() == first || one.at("rgba").host() == first ||
              two.at("rgba").host() == first);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(import.use_count(), 2) << "the memory keeps it";
}

TEST(DeviceArrays, OutliveTheirRendererAndScene) {
  std::map<std::string, DeviceArray> arrays;
  std::vector<float> expected;
  {
    const Shop shop;
    latelight::Renderer renderer(shop.scene, "cpu");
    arrays = shop.render(renderer);
    expected = renderer.render(shop.camera, shop.options).aovs.at("depth").values;
  }
  EXPECT_EQ(std::memcmp(arrays.at("depth").host(), expected.data(), expected.size() * sizeof(float)), 0);
}

TEST(DeviceArrays, EmptyOnesAreRejected) {
  std::map<std::string, DeviceArray> arrays;
  const DeviceArray& array = arrays["dpeth"];
  std::byte byte{};
  const std::vector<std::function<void()>> calls = {[&] { array.host(); },
                                                    [&] { array.exportMemory(); },
                                                    [&] { array.memoryBytes(); },
                                                    [&] { array.deviceUuid(); },
                                                    [&] { array.attach(nullptr); },
                                                    [&] { array.attached(); },
                                                    [&] {
                                                      array.copyToHost({&byte, 1});
                                                    },
                                                    [&] { array.beforeReuse([] {}); }};
  for (const auto& call : calls) {
    try {
      call();
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::Usage);
      EXPECT_THAT(error.what(), testing::HasSubstr("this array is empty"));
    }
  }
}

TEST(DeviceArrays, AreTakenAsTheyWereAskedFor) {
  const Shop shop;
  latelight::Renderer renderer(shop.scene, "cpu");
  latelight::Ticket arrays = renderer.submit({shop.camera}, shop.options, latelight::Results::Arrays);
  EXPECT_THROW(arrays.take(), Error);
  const DeviceArray depth = arrays.takeArrays().at("depth");
  EXPECT_THROW(arrays.takeArrays(), Error);
  EXPECT_THROW(depth.exportMemory(), Error) << "the host has it";
  latelight::Ticket pictures = renderer.submit({shop.camera}, shop.options);
  EXPECT_THROW(pictures.takeArrays(), Error);
  EXPECT_EQ(pictures.take().size(), 1u);
  { const latelight::Ticket dropped = renderer.submit({shop.camera}, shop.options, latelight::Results::Arrays); }
  EXPECT_EQ(shop.render(renderer).size(), 2u);
}

}  // namespace
}  // namespace latelight::render::test
