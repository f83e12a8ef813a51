// Compute pipelines, descriptor sets, and the names and variants of embedded shaders.
#include "vk/pipeline.h"

#include <algorithm>

#include "base/error.h"
#include "test_device.h"
#include "vk/commands.h"
#include "vk/device_fixture.h"
#include "vk/object_cache.h"
#include "vk/tiny_shader.h"

namespace latelight::vk {
namespace {

struct Push {
  uint64_t words;
  uint32_t width, height, add;
};

constexpr uint32_t kWidth = 37, kHeight = 11;  // not multiples of the workgroup's 8x4

struct Tiny {
  explicit Tiny(Device& device)
      : pipeline(makePipeline(device, ComputeDesc{.bindings = {Binding::Sampled, Binding::Storage},
                                                  .constants = {{ConstantId{3}, 5}},
                                                  .pushBytes = sizeof(Push),
                                                  .name = "tiny",
                                                  .code = {std::begin(kTinyShader), std::end(kTinyShader)}})),
        source(device, {VK_FORMAT_R8G8B8A8_UNORM, kWidth, kHeight, 1, 1, 1,
                        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, "source"}),
        target(device,
               {VK_FORMAT_R8G8B8A8_UNORM, kWidth, kHeight, 1, 1, 1,
                VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, "target"}),
        words(device, {.size = kWidth * kHeight * 4, .kind = MemoryKind::Readback, .name = "words"}),
        sampler(makeSampler(device, {})) {}

  Pipeline pipeline;
  Image source, target;
  Buffer words;
  Handle<VkSampler> sampler;
};

void recordLayout(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to) {
  VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
  barrier.srcStageMask = barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.image = image.get();
  barrier.subresourceRange = {image.aspect(), 0, 1, 0, 1};
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.imageMemoryBarrierCount = 1;
  info.pImageMemoryBarriers = &barrier;
  vkCmdPipelineBarrier2(commands, &info);
}

TEST_F(DeviceTest, AComputePipelineReadsImagesConstantsAndAddresses) {
  Tiny tiny(device());
  const std::vector<std::byte> picture = pattern(kWidth * kHeight * 4);
  Uploader(device()).upload(tiny.source, picture);
  DescriptorPool pool(device());
  device().submitAndWait([&](VkCommandBuffer buffer) {
    recordLayout(buffer, tiny.target, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
    Commands commands(buffer, pool);
    commands.bind(tiny.pipeline, {{tiny.source.view(), tiny.sampler.get()}, {tiny.target.view()}},
                  Push{tiny.words.address(), kWidth, kHeight, 1000});
    commands.dispatch(kWidth, kHeight, 1, 8, 4);
    recordLayout(buffer, tiny.target, VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_READ_ONLY_OPTIMAL);
    recordHostBarrier(buffer);
  });
  const std::vector<std::byte> turned = readBack(device(), tiny.target);
  for (uint32_t i = 0; i < kWidth * kHeight; ++i) {
    ASSERT_EQ(tiny.words.as<uint32_t>()[i], i * 5 + 1000) << "word " << i;
    for (uint32_t channel = 0; channel < 4; ++channel)
      ASSERT_EQ(turned[i * 4 + channel], picture[i * 4 + 3 - channel]) << "texel " << i << " channel " << channel;
  }
}

TEST_F(DeviceTest, DescriptorSetsGrowAndAreReused) {
  Tiny tiny(device());
  const std::vector<BoundImage> images{{tiny.source.view(), tiny.sampler.get()}, {tiny.target.view()}};
  DescriptorPool pool(device());
  std::vector<VkDescriptorSet> sets;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 1000; ++i) sets.push_back(pool.make(tiny.pipeline.set0, tiny.pipeline.bindings, images));
    EXPECT_EQ(std::count(sets.begin(), sets.end(), VkDescriptorSet{VK_NULL_HANDLE}), 0);
    pool.reset();
  }
}

TEST_F(DeviceTest, SetLayoutsOfAnySize) {
  const std::vector<Binding> five(5, Binding::Sampled);
  EXPECT_TRUE(makeSetLayout(device(), five));
  EXPECT_TRUE(makeSetLayout(device(), {})) << "a set with nothing in it";
}

TEST(Shaders, NamesHaveTheLayoutFirstAndThenTheVariants) {
  ShaderKey key("a.frag", "thin");
  EXPECT_EQ(key.name(), "a.frag@thin");
  key.samples = ShaderKey::Samples::Multisampled;
  key.indexed = true;
  EXPECT_EQ(key.name(), "a.frag@thin+msaa+indexed");
  key.samples = ShaderKey::Samples::SampleLayers;
  key.coated = true;
  EXPECT_EQ(key.name(), "a.frag@thin+sample-layers+coated+indexed");
  ShaderKey raster("a.comp");
  raster.hit = ShaderKey::Hit::LensBlended;
  EXPECT_EQ(raster.name(), "a.comp+lens-blended");
  raster.indexed = true;
  EXPECT_EQ(raster.name(), "a.comp+lens-blended+indexed");
}

TEST(Shaders, TheRasterHasAVariantPerKindOfHit) {
  using enum ShaderKey::Hit;
  for (const ShaderKey::Hit hit : {Opaque, Masked, Blended, Overdraw, Lens, LensBlended}) {
    for (const char* file : {"raster.comp", "raster_large.comp"}) {
      ShaderKey key = file;
      key.hit = hit;
      EXPECT_TRUE(hasShader(key)) << key.name();
      key.indexed = true;
      EXPECT_EQ(hasShader(key), hit == Masked || hit == Lens || hit == LensBlended) << key.name();
    }
  }
}

TEST(Shaders, UnknownOnesAreNamed) {
  ShaderKey unknown("screen.vert");
  EXPECT_TRUE(hasShader(unknown));
  unknown.coated = true;
  EXPECT_FALSE(hasShader(unknown));
  try {
    shaderCode(unknown);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Internal);
    EXPECT_STREQ(error.what(),
                 "No shader called screen.vert+coated is embedded: check the first line of screen.vert, which declares "
                 "its variants.");
  }
}

// An error may end a device's life at once, while threads still create its pipelines.
TEST(DeviceLifeTest, EndsWhilePipelinesAreCreated) {
  for (uint32_t round = 0; round < 10; ++round) {
    Device device({.selector = test::testDevice()});
    for (uint32_t i = 0; i < 8; ++i)
      device.cache().pipeline(ComputeDesc{.bindings = {Binding::Sampled, Binding::Storage},
                                          .constants = {{ConstantId{3}, i}},
                                          .pushBytes = sizeof(Push),
                                          .name = "tiny",
                                          .code = {std::begin(kTinyShader), std::end(kTinyShader)}});
  }
}

}  // namespace
}  // namespace latelight::vk
