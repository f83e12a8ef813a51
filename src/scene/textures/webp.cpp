// Decodes WebP images with libwebp.
#include <webp/decode.h>

#include "base/error.h"
#include "scene/textures/codecs.h"

namespace latelight::scene {
namespace {

ImageSize sizeOfWebp(std::span<const std::byte> encoded, const std::string& name) {
  int width = 0, height = 0;
  if (!WebPGetInfo(bytesOf(encoded), encoded.size(), &width, &height)) badInput("{} is an invalid WebP image", name);
  return {uint32_t(width), uint32_t(height)};
}

void decodeWebp(std::span<const std::byte> encoded, const std::string& name, ImageSize size, std::byte* rgba) {
  size_t pitch = size_t(size.width) * 4;
  if (!WebPDecodeRGBAInto(bytesOf(encoded), encoded.size(), reinterpret_cast<uint8_t*>(rgba), pitch * size.height,
                          int(pitch)))
    badInput("{} is an invalid or animated WebP image", name);
}

}  // namespace

const Codec kWebpCodec{sizeOfWebp, decodeWebp};

}  // namespace latelight::scene
