// Decodes PNG images with libspng.
#include <spng.h>

#include <memory>

#include "base/error.h"
#include "scene/textures/codecs.h"

namespace latelight::scene {
namespace {

using Context = std::unique_ptr<spng_ctx, void (*)(spng_ctx*)>;

void check(int result, const std::string& name) {
  if (result != 0) badInput("{} is an invalid PNG image: {}", name, spng_strerror(result));
}

Context open(std::span<const std::byte> encoded, const std::string& name) {
  Context context(spng_ctx_new(0), spng_ctx_free);
  if (!context) throw std::bad_alloc();
  // Text and profile chunks are skipped, but limits prevent an invalid one from requesting gigabytes.
  check(spng_set_chunk_limits(context.get(), 64u << 20, 64u << 20), name);
  check(spng_set_png_buffer(context.get(), encoded.data(), encoded.size()), name);
  return context;
}

ImageSize sizeOfPng(std::span<const std::byte> encoded, const std::string& name) {
  Context context = open(encoded, name);
  spng_ihdr header{};
  check(spng_get_ihdr(context.get(), &header), name);
  return {header.width, header.height};
}

// Color profiles and gamma are ignored, as glTF 2.0 (3.8.3) requires.
void decodePng(std::span<const std::byte> encoded, const std::string& name, ImageSize size, std::byte* rgba) {
  Context context = open(encoded, name);
  size_t bytes = size_t(size.width) * size.height * 4;
  check(spng_decode_image(context.get(), rgba, bytes, SPNG_FMT_RGBA8, SPNG_DECODE_TRNS), name);
}

}  // namespace

const Codec kPngCodec{sizeOfPng, decodePng};

}  // namespace latelight::scene
