// Decodes PNG images with libspng.
#include <spng.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

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

// libspng truncates 16 bits per channel to 8, so these images are decoded with 16 bits, row by row to save memory, and
// rounded.
void decodeRounded(spng_ctx* context, const std::string& name, ImageSize size, bool isInterlaced, std::byte* rgba) {
  struct Pass {
    size_t first, step;  // in pixels of a row (PNG, Third Edition, section 8.2)
  };
  constexpr std::array<Pass, 7> kInterlacePasses = {{{0, 8}, {4, 8}, {0, 4}, {2, 4}, {0, 2}, {1, 2}, {0, 1}}};
  check(spng_decode_image(context, nullptr, 0, SPNG_FMT_RGBA16, SPNG_DECODE_TRNS | SPNG_DECODE_PROGRESSIVE), name);
  std::vector<std::array<uint16_t, 4>> row(size.width);
  int result = 0;
  while (result == 0) {
    spng_row_info info{};
    check(spng_get_row_info(context, &info), name);
    result = spng_decode_row(context, row.data(), row.size() * sizeof(row[0]));  // SPNG_EOI with the last row
    if (result != SPNG_EOI) check(result, name);
    const auto [first, step] = isInterlaced ? kInterlacePasses[size_t(info.pass)] : Pass{0, 1};
    for (size_t x = first; x < row.size(); x += step)
      for (size_t channel = 0; channel < 4; ++channel)
        rgba[4 * (size_t{info.row_num} * size.width + x) + channel] = std::byte((row[x][channel] + 128) / 257);
  }
}

// Color profiles and gamma are ignored, as glTF 2.0 (3.8.3) requires.
void decodePng(std::span<const std::byte> encoded, const std::string& name, ImageSize size, std::byte* rgba) {
  Context context = open(encoded, name);
  spng_ihdr header{};
  check(spng_get_ihdr(context.get(), &header), name);
  if (header.bit_depth == 16) return decodeRounded(context.get(), name, size, header.interlace_method != 0, rgba);
  size_t bytes = size_t(size.width) * size.height * 4;
  check(spng_decode_image(context.get(), rgba, bytes, SPNG_FMT_RGBA8, SPNG_DECODE_TRNS), name);
}

}  // namespace

const Codec kPngCodec{sizeOfPng, decodePng};

}  // namespace latelight::scene
