// Decodes AVIF images with libavif if the program was built with it.
#ifdef LATELIGHT_AVIF
#include <avif/avif.h>
#endif

#include <memory>

#include "base/error.h"
#include "scene/textures/codecs.h"

namespace latelight::scene {

#ifdef LATELIGHT_AVIF

namespace {

using AvifDecoder = std::unique_ptr<avifDecoder, void (*)(avifDecoder*)>;

void checkAvif(avifResult result, const std::string& name) {
  if (result != AVIF_RESULT_OK) badInput("{} is an invalid AVIF image: {}", name, avifResultToString(result));
}

AvifDecoder openAvif(std::span<const std::byte> encoded, const std::string& name) {
  AvifDecoder decoder(avifDecoderCreate(), avifDecoderDestroy);
  if (!decoder) throw std::bad_alloc();
  decoder->imageDimensionLimit = kMaxTextureSide;
  decoder->ignoreExif = decoder->ignoreXMP = AVIF_TRUE;
  checkAvif(avifDecoderSetIOMemory(decoder.get(), reinterpret_cast<const uint8_t*>(encoded.data()), encoded.size()),
            name);
  checkAvif(avifDecoderParse(decoder.get()), name);
  return decoder;
}

ImageSize sizeOfAvif(std::span<const std::byte> encoded, const std::string& name) {
  const AvifDecoder decoder = openAvif(encoded, name);
  return {decoder->image->width, decoder->image->height};
}

// Color profiles are ignored, as glTF 2.0 (3.8.3) requires. The first image of an animation is decoded.
void decodeAvif(std::span<const std::byte> encoded, const std::string& name, ImageSize size, std::byte* rgba) {
  const AvifDecoder decoder = openAvif(encoded, name);
  checkAvif(avifDecoderNextImage(decoder.get()), name);
  if (decoder->image->width != size.width || decoder->image->height != size.height)
    badInput("{} is an invalid AVIF image: it states two different sizes", name);
  avifRGBImage target;
  avifRGBImageSetDefaults(&target, decoder->image);
  target.depth = 8;
  target.format = AVIF_RGB_FORMAT_RGBA;
  target.pixels = reinterpret_cast<uint8_t*>(rgba);
  target.rowBytes = 4 * size.width;
  checkAvif(avifImageYUVToRGB(decoder->image, &target), name);
}

}  // namespace

const Codec kAvifCodec{sizeOfAvif, decodeAvif};

#else

namespace {

ImageSize rejectAvif(std::span<const std::byte>, const std::string& name) {
  badInput("{} is an AVIF image, but this program was built without libavif: convert it to PNG, JPEG or WebP", name);
}

}  // namespace

const Codec kAvifCodec{rejectAvif};

#endif

}  // namespace latelight::scene
