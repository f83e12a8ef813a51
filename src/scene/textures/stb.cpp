// BMP, TGA and GIF images, which glTF does not allow but which occur in real files.
//
// stb_image reads zeros after the end of its input, or leaves rows as they were allocated, and returns an image anyway.
// The decoder therefore records such reads, and memory for pixels is zeroed.
#include <cstdlib>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_BMP
#define STBI_ONLY_TGA
#define STBI_ONLY_GIF
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 16384
#define STBI_MALLOC(size) std::calloc(1, size)
#define STBI_REALLOC(memory, size) std::realloc(memory, size)
#define STBI_FREE(memory) std::free(memory)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>

#include "base/error.h"
#include "scene/textures/codecs.h"

namespace latelight::scene {
namespace {

static_assert(STBI_MAX_DIMENSIONS == kMaxTextureSide);

int lengthOf(std::span<const std::byte> encoded, const std::string& name) {
  if (encoded.size() > size_t(std::numeric_limits<int>::max())) badInput("{} is larger than 2 GiB", name);
  return int(encoded.size());
}

ImageSize sizeOfStb(std::span<const std::byte> encoded, const std::string& name) {
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(bytesOf(encoded), lengthOf(encoded, name), &width, &height, &channels))
    badInput("{} is an invalid image: {}", name, stbi_failure_reason());
  // stb_image returns the height of a BMP header, which is negative if the rows are stored from the top.
  return {uint32_t(width), height < 0 ? 0u - uint32_t(height) : uint32_t(height)};
}

// stb_image ignores that the columns of a TGA image may be stored from the right (Truevision TGA 2.0, field 5.6, bit
// 4). The type of its color map is 0 or 1; files of the other formats begin with "BM" and "GIF".
bool isFromRight(std::span<const std::byte> encoded) {
  constexpr size_t kColorMapType = 1, kDescriptor = 17;
  const bool isTga = encoded[kColorMapType] <= std::byte{1};
  return isTga && (encoded[kDescriptor] & std::byte{0x10}) != std::byte{0};
}

void mirror(ImageSize size, std::byte* rgba) {
  constexpr size_t kTexelBytes = 4;
  for (std::byte* row = rgba; row != rgba + kTexelBytes * size.width * size.height; row += kTexelBytes * size.width)
    for (size_t x = 0; x < size.width / 2; ++x)
      std::swap_ranges(row + kTexelBytes * x, row + kTexelBytes * (x + 1), row + kTexelBytes * (size.width - 1 - x));
}

// Callbacks for an input that is in memory as a whole. stb_image calls read() only if it requires bytes after the end.
// It also skips padding there, which files may omit.
int readAfterEnd(void* isTruncated, char*, int) {
  *static_cast<bool*>(isTruncated) = true;
  return 0;
}
void skipAfterEnd(void*, int) {}
int isAtEnd(void*) {
  return 1;
}

void decodeStb(std::span<const std::byte> encoded, const std::string& name, ImageSize size, std::byte* rgba) {
  int width = 0, height = 0, channels = 0;
  bool isTruncated = false;
  stbi__context input{};
  stbi__start_mem(&input, bytesOf(encoded), lengthOf(encoded, name));
  input.io = {.read = readAfterEnd, .skip = skipAfterEnd, .eof = isAtEnd};
  input.io_user_data = &isTruncated;
  input.read_from_callbacks = 1;
  std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
      stbi__load_and_postprocess_8bit(&input, &width, &height, &channels, 4), stbi_image_free);
  if (isTruncated) badInput("{} is an invalid image: it is truncated", name);
  if (!pixels) badInput("{} is an invalid image: {}", name, stbi_failure_reason());
  if (uint32_t(width) != size.width || uint32_t(height) != size.height)
    badInput("{} is an invalid image: it states two different sizes", name);
  std::memcpy(rgba, pixels.get(), size_t(width) * size_t(height) * 4);
  if (isFromRight(encoded)) mirror(size, rgba);
}

}  // namespace

const Codec kStbCodec{sizeOfStb, decodeStb};

}  // namespace latelight::scene
