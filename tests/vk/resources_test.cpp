// Buffers and images: uploads of every format, directly and through staging memory, moves, and format properties.
#include <algorithm>
#include <array>

#include "base/error.h"
#include "vk/device_fixture.h"

namespace latelight::vk {
namespace {

constexpr VkImageUsageFlags kCopied = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
constexpr VkImageUsageFlags kTexture = kCopied | VK_IMAGE_USAGE_SAMPLED_BIT;

size_t imageBytes(const ImageDesc& desc) {
  size_t bytes = 0;
  for (uint32_t level = 0; level < desc.levels; ++level)
    bytes += size_t{std::max(desc.width >> level, 1u)} * std::max(desc.height >> level, 1u) * texelBytes(desc.format);
  return bytes;
}

// Any bits are a valid color, but a depth must be a number in [0, 1].
std::vector<std::byte> texels(const ImageDesc& desc, uint32_t seed) {
  std::vector<std::byte> bytes = pattern(imageBytes(desc), seed);
  if (desc.format == VK_FORMAT_D32_SFLOAT || desc.format == VK_FORMAT_D32_SFLOAT_S8_UINT)
    for (size_t i = 0; i + 4 <= bytes.size(); i += 4) {
      const float depth = static_cast<float>(i % 4093) / 4093.0f;
      std::memcpy(&bytes[i], &depth, 4);
    }
  if (desc.format == VK_FORMAT_X8_D24_UNORM_PACK32 || desc.format == VK_FORMAT_D24_UNORM_S8_UINT)
    for (size_t i = 3; i < bytes.size(); i += 4) bytes[i] = std::byte{0};
  return bytes;
}

// Every format of the table that the device can sample.
std::vector<VkFormat> sampledFormats(Device& device) {
  std::vector<VkFormat> formats;
  for (int i = 1; i <= VK_FORMAT_D32_SFLOAT_S8_UINT; ++i) {
    const VkFormat format = static_cast<VkFormat>(i);
    try {
      texelBytes(format);
    } catch (const Error&) {
      continue;
    }
    VkImageFormatProperties properties;
    if (vkGetPhysicalDeviceImageFormatProperties(device.physical(), format, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL,
                                                 kTexture, 0, &properties) == VK_SUCCESS)
      formats.push_back(format);
  }
  return formats;
}

class UploadTest : public DeviceTest, public testing::WithParamInterface<bool> {};
INSTANTIATE_TEST_SUITE_P(Modes, UploadTest, testing::Values(false, true),
                         [](const auto& info) { return info.param ? "Staged" : "Direct"; });

TEST_P(UploadTest, ImagesOfEveryFormatAndOddSizesAreReadBackUnchanged) {
  const std::vector<VkFormat> formats = sampledFormats(device());
  EXPECT_GE(formats.size(), 35u);
  for (VkFormat format : formats) {
    std::vector<Image> images;
    std::vector<std::vector<std::byte>> data;
    Uploader uploader(device(), GetParam() ? UploadMode::Staged : UploadMode::Direct);
    for (auto [width, height, levels] : {std::array{1u, 1u, 1u}, {7u, 5u, 3u}, {131u, 67u, 8u}, {1u, 300u, 2u}})
      for (bool oddBase : {false, true}) {
        const ImageDesc desc{format, width, height, 1, levels, 1, kTexture, formatName(format), oddBase};
        images.emplace_back(device(), desc);
        data.push_back(texels(desc, static_cast<uint32_t>(data.size())));
        uploader.upload(images.back(), data.back());
      }
    uploader.flush();
    for (size_t i = 0; i < images.size(); ++i) {
      std::vector<std::byte> back = readBack(device(), images[i]);
      // The byte next to a 24-bit depth is undefined.
      if (format == VK_FORMAT_X8_D24_UNORM_PACK32 || format == VK_FORMAT_D24_UNORM_S8_UINT)
        for (size_t k = 3; k < back.size(); k += 4) back[k] = std::byte{0};
      EXPECT_TRUE(back == data[i]) << formatName(format) << " " << images[i].desc().width;
    }
  }
}

TEST_P(UploadTest, AnImageLargerThanTheStagingMemoryArrivesComplete) {
  const ImageDesc desc{VK_FORMAT_R8G8B8A8_UNORM, 2501, 2503, 1, 3, 1, kTexture, "large"};
  const Image image(device(), desc);
  const Image small(device(), {VK_FORMAT_R8_UNORM, 3, 3, 1, 1, 1, kTexture, "small"});
  const std::vector<std::byte> data = texels(desc, 3), few = pattern(9);
  {
    Uploader uploader(device(), GetParam() ? UploadMode::Staged : UploadMode::Direct);
    uploader.upload(small, few);
    uploader.upload(image, data);
    uploader.upload(small, pattern(9, 2));
  }
  EXPECT_TRUE(readBack(device(), image) == data);
  EXPECT_TRUE(readBack(device(), small) == pattern(9, 2)) << "the later upload of an image wins";
}

TEST_F(DeviceTest, BuffersArriveDirectlyAndThroughStaging) {
  for (bool alwaysStage : {false, true})
    for (size_t size : {size_t{1}, size_t{4099}, size_t{40} << 20}) {
      const Buffer buffer(device(), {.size = size + 8, .name = "uploaded"});
      std::vector<std::byte> expected = pattern(size + 8, 9);
      Uploader(device(), UploadMode::Staged).upload(buffer, expected);
      const std::vector<std::byte> data = pattern(size);
      Uploader uploader(device(), alwaysStage ? UploadMode::Staged : UploadMode::Direct);
      uploader.upload(buffer, data, 4);
      uploader.flush();
      std::copy(data.begin(), data.end(), expected.begin() + 4);
      EXPECT_TRUE(readBack(device(), buffer) == expected) << size << (alwaysStage ? " staged" : " direct");
    }
}

TEST_F(DeviceTest, TheLaterOfTwoOverlappingUploadsWins) {
  const Buffer buffer(device(), {.size = 100});
  {
    Uploader uploader(device(), UploadMode::Staged);
    uploader.upload(buffer, std::vector<std::byte>(100, std::byte{1}));
    uploader.upload(buffer, std::vector<std::byte>(10, std::byte{2}), 50);
    uploader.upload(buffer, {}, 100);
  }
  const std::vector<std::byte> bytes = readBack(device(), buffer);
  EXPECT_EQ(std::ranges::count(bytes, std::byte{2}), 10);
  EXPECT_EQ(bytes[49], std::byte{1});
  EXPECT_EQ(bytes[59], std::byte{2});
}

TEST_F(DeviceTest, DeferredUploadsMayOutliveTheirDestinations) {
  Uploader uploader(device(), UploadMode::Deferred);
  const Buffer buffer(device(), {.size = 64});
  EXPECT_EQ(readBack(device(), buffer).size(), 64u);  // a submission has used it, so it is no longer written in place
  uploader.upload(buffer, pattern(64));
  EXPECT_FALSE(uploader.empty());
}

// Validation reports a copy to a destroyed buffer or image.
TEST_F(DeviceTest, PendingUploadsToDestroyedResourcesAreDropped) {
  for (const UploadMode mode : {UploadMode::Deferred, UploadMode::Staged}) {
    Uploader uploader(device(), mode);
    Buffer replaced(device(), {.size = 64}), kept(device(), {.size = 64});
    auto image = std::make_unique<Image>(device(), ImageDesc{VK_FORMAT_R8_UNORM, 8, 8, 1, 1, 1, kTexture, "destroyed"});
    EXPECT_EQ(readBack(device(), kept).size(), 64u);  // buffers that a submission may use are not written in place
    uploader.upload(replaced, pattern(64, 1));
    uploader.upload(*image, pattern(64, 2));
    uploader.upload(kept, pattern(64, 3));
    replaced = Buffer(device(), {.size = 64});
    uploader.upload(replaced, pattern(64, 4));
    image.reset();
    if (mode == UploadMode::Deferred) {
      device().submitAndWait([&](VkCommandBuffer commands) { uploader.record(commands); });
      uploader.forget();
    } else {
      uploader.flush();
    }
    EXPECT_EQ(readBack(device(), kept), pattern(64, 3));
    EXPECT_EQ(readBack(device(), replaced), pattern(64, 4));
  }
}

TEST_F(DeviceTest, ResourcesMove) {
  Buffer first(device(), {.size = 64, .name = "first"}), second;
  const VkBuffer object = first.get();
  second = std::move(first);
  EXPECT_EQ(second.get(), object);
  EXPECT_FALSE(first);
  EXPECT_EQ(second.size(), 64u);
  Image image(device(), {VK_FORMAT_R16_SFLOAT, 8, 8, 3, 1, 1, kTexture, "layers"});
  const Image moved = std::move(image);
  EXPECT_FALSE(image);
  EXPECT_NE(moved.layerView(0), moved.layerView(2));
  EXPECT_NE(moved.arrayView(), VK_NULL_HANDLE);
}

TEST_F(DeviceTest, EmptyBuffersCanBeBound) {
  const Buffer buffer(device(), {.size = 0});
  EXPECT_EQ(buffer.size(), 16u);
  EXPECT_NE(buffer.address(), 0u);
}

// The bytes of a texel in a buffer, the channels and their type are those of the Vulkan specification, "Formats". Depth
// is copied without its stencil: 4 bytes for D24 and D32, 2 for D16.
TEST(Formats, HaveNamesSizesChannelsAndKinds) {
  using enum FormatKind;
  struct Expected {
    VkFormat format;
    const char* name;
    uint32_t bytes, channels;
    FormatKind kind;
  };
  const Expected all[] = {
      {VK_FORMAT_R8_UNORM, "R8_UNORM", 1, 1, Unorm},
      {VK_FORMAT_R8_SNORM, "R8_SNORM", 1, 1, Snorm},
      {VK_FORMAT_R8_UINT, "R8_UINT", 1, 1, Uint},
      {VK_FORMAT_R8_SRGB, "R8_SRGB", 1, 1, Srgb},
      {VK_FORMAT_R8G8_UNORM, "R8G8_UNORM", 2, 2, Unorm},
      {VK_FORMAT_R8G8_SNORM, "R8G8_SNORM", 2, 2, Snorm},
      {VK_FORMAT_R8G8_UINT, "R8G8_UINT", 2, 2, Uint},
      {VK_FORMAT_R8G8_SRGB, "R8G8_SRGB", 2, 2, Srgb},
      {VK_FORMAT_R8G8B8A8_UNORM, "R8G8B8A8_UNORM", 4, 4, Unorm},
      {VK_FORMAT_R8G8B8A8_SNORM, "R8G8B8A8_SNORM", 4, 4, Snorm},
      {VK_FORMAT_R8G8B8A8_UINT, "R8G8B8A8_UINT", 4, 4, Uint},
      {VK_FORMAT_R8G8B8A8_SRGB, "R8G8B8A8_SRGB", 4, 4, Srgb},
      {VK_FORMAT_B8G8R8A8_UNORM, "B8G8R8A8_UNORM", 4, 4, Unorm},
      {VK_FORMAT_B8G8R8A8_SRGB, "B8G8R8A8_SRGB", 4, 4, Srgb},
      {VK_FORMAT_A2B10G10R10_UNORM_PACK32, "A2B10G10R10_UNORM_PACK32", 4, 4, Unorm},
      {VK_FORMAT_A2B10G10R10_UINT_PACK32, "A2B10G10R10_UINT_PACK32", 4, 4, Uint},
      {VK_FORMAT_B10G11R11_UFLOAT_PACK32, "B10G11R11_UFLOAT_PACK32", 4, 3, Ufloat},
      {VK_FORMAT_E5B9G9R9_UFLOAT_PACK32, "E5B9G9R9_UFLOAT_PACK32", 4, 3, Ufloat},
      {VK_FORMAT_R16_UNORM, "R16_UNORM", 2, 1, Unorm},
      {VK_FORMAT_R16_SNORM, "R16_SNORM", 2, 1, Snorm},
      {VK_FORMAT_R16_UINT, "R16_UINT", 2, 1, Uint},
      {VK_FORMAT_R16_SFLOAT, "R16_SFLOAT", 2, 1, Sfloat},
      {VK_FORMAT_R16G16_UNORM, "R16G16_UNORM", 4, 2, Unorm},
      {VK_FORMAT_R16G16_SNORM, "R16G16_SNORM", 4, 2, Snorm},
      {VK_FORMAT_R16G16_UINT, "R16G16_UINT", 4, 2, Uint},
      {VK_FORMAT_R16G16_SFLOAT, "R16G16_SFLOAT", 4, 2, Sfloat},
      {VK_FORMAT_R16G16B16A16_UNORM, "R16G16B16A16_UNORM", 8, 4, Unorm},
      {VK_FORMAT_R16G16B16A16_SNORM, "R16G16B16A16_SNORM", 8, 4, Snorm},
      {VK_FORMAT_R16G16B16A16_UINT, "R16G16B16A16_UINT", 8, 4, Uint},
      {VK_FORMAT_R16G16B16A16_SFLOAT, "R16G16B16A16_SFLOAT", 8, 4, Sfloat},
      {VK_FORMAT_R32_UINT, "R32_UINT", 4, 1, Uint},
      {VK_FORMAT_R32_SFLOAT, "R32_SFLOAT", 4, 1, Sfloat},
      {VK_FORMAT_R32G32_UINT, "R32G32_UINT", 8, 2, Uint},
      {VK_FORMAT_R32G32_SFLOAT, "R32G32_SFLOAT", 8, 2, Sfloat},
      {VK_FORMAT_R32G32B32A32_UINT, "R32G32B32A32_UINT", 16, 4, Uint},
      {VK_FORMAT_R32G32B32A32_SFLOAT, "R32G32B32A32_SFLOAT", 16, 4, Sfloat},
      {VK_FORMAT_R64_UINT, "R64_UINT", 8, 1, Uint},
      {VK_FORMAT_D16_UNORM, "D16_UNORM", 2, 1, Depth},
      {VK_FORMAT_X8_D24_UNORM_PACK32, "X8_D24_UNORM_PACK32", 4, 1, Depth},
      {VK_FORMAT_D32_SFLOAT, "D32_SFLOAT", 4, 1, Depth},
      {VK_FORMAT_D24_UNORM_S8_UINT, "D24_UNORM_S8_UINT", 4, 1, Depth},
      {VK_FORMAT_D32_SFLOAT_S8_UINT, "D32_SFLOAT_S8_UINT", 4, 1, Depth},
  };
  for (const Expected& expected : all) {
    EXPECT_STREQ(formatName(expected.format), expected.name);
    EXPECT_EQ(texelBytes(expected.format), expected.bytes) << expected.name;
    EXPECT_EQ(channelCount(expected.format), expected.channels) << expected.name;
    EXPECT_EQ(formatKind(expected.format), expected.kind) << expected.name;
    EXPECT_EQ(isDepth(expected.format), expected.kind == Depth) << expected.name;
  }
  EXPECT_THROW(formatName(VK_FORMAT_UNDEFINED), Error);
}

}  // namespace
}  // namespace latelight::vk
