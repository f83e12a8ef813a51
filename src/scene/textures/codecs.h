// Image codecs, one per file, texture_<codec>.cpp. texture.cpp chooses one by an image's first bytes.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "scene/textures/texture.h"

namespace latelight::scene {

struct Codec {
  // Reads the size from only the header. Throws Error(BadInput) with `name`.
  ImageSize (*size)(std::span<const std::byte> encoded, const std::string& name);
  // Writes width * height RGBA pixels, rows from the top, straight (not premultiplied) alpha.
  void (*decode)(std::span<const std::byte> encoded, const std::string& name, ImageSize size,
                 std::byte* rgba) = nullptr;
  // Replaces `decode` for formats with mip levels: fills all levels or only the first, and returns their number.
  uint32_t (*decodeLevels)(std::span<const std::byte> encoded, Texture& texture) = nullptr;
};

// As the libraries take them.
inline const unsigned char* bytesOf(std::span<const std::byte> encoded) {
  return reinterpret_cast<const unsigned char*>(encoded.data());
}

extern const Codec kAvifCodec;
extern const Codec kJpegCodec;
extern const Codec kPngCodec;
extern const Codec kWebpCodec;
extern const Codec kKtx2Codec;
extern const Codec kStbCodec;  // BMP, TGA, GIF

}  // namespace latelight::scene
