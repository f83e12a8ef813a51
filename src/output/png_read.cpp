#include <spng.h>

#include <memory>
#include <new>

#include "base/error.h"
#include "output/decode.h"
#include "output/png.h"

namespace latelight::output {
namespace {

struct Layout {
  spng_format format;
  uint32_t channels, bytes;
};

// Selects the format that libspng decodes to. Palettes, depths below 8 bits and transparent colors are expanded.
Layout layoutOf(spng_ctx* context, const spng_ihdr& header) {
  spng_trns transparent{};
  const bool keyed = spng_get_trns(context, &transparent) == SPNG_OK;
  if (header.bit_depth == 16 && keyed) return {SPNG_FMT_RGBA16, 4, 2};
  if (keyed) return {SPNG_FMT_RGBA8, 4, 1};
  const uint32_t bytes = header.bit_depth == 16 ? 2 : 1;
  switch (header.color_type) {
    case SPNG_COLOR_TYPE_GRAYSCALE:
      return {header.bit_depth < 8 ? SPNG_FMT_G8 : SPNG_FMT_PNG, 1, bytes};
    case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA:
      return {SPNG_FMT_PNG, 2, bytes};
    case SPNG_COLOR_TYPE_TRUECOLOR:
      return {SPNG_FMT_PNG, 3, bytes};
    case SPNG_COLOR_TYPE_TRUECOLOR_ALPHA:
      return {SPNG_FMT_PNG, 4, bytes};
    default:
      return {SPNG_FMT_RGB8, 3, 1};
  }
}

// Deflate compresses at most 1032 bytes into one. A header that declares more is broken, and its memory would be
// wasted.
bool canHold(size_t fileBytes, const spng_ihdr& header) {
  constexpr uint64_t kSamples[] = {1, 0, 3, 1, 2, 0, 4};  // per pixel, by color type
  const uint64_t bits = kSamples[header.color_type] * header.bit_depth;
  return uint64_t{header.width} * header.height / 8 * bits <= fileBytes * 1032;
}

}  // namespace

ReadImage decodePng(std::span<const std::byte> bytes, const std::filesystem::path& path) {
  const auto check = [&](int result) {
    if (result != SPNG_OK) {
      badInput("can't read '{}' as PNG: {}; create or download it again", path.string(), spng_strerror(result));
    }
  };
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> context(spng_ctx_new(0), spng_ctx_free);
  if (!context) throw std::bad_alloc();
  constexpr size_t kMaxInChunk = size_t{16} << 20;  // for text, profiles, ...: compressed ones can grow a thousandfold
  check(spng_set_chunk_limits(context.get(), kMaxInChunk, 4 * kMaxInChunk));
  check(spng_set_png_buffer(context.get(), bytes.data(), bytes.size()));
  spng_ihdr header{};
  check(spng_get_ihdr(context.get(), &header));
  const Layout layout = layoutOf(context.get(), header);
  const size_t pixels = size_t{header.width} * header.height;
  size_t size = 0;
  check(spng_decoded_image_size(context.get(), layout.format, &size));
  if (size != pixels * layout.channels * layout.bytes) {
    badInput("can't read '{}' as PNG: its rows have an unexpected size; save it as 8 or 16 bit RGBA", path.string());
  }
  if (!canHold(bytes.size(), header)) {
    badInput("can't read '{}' as PNG: it is too short for {}x{} pixels; create or download it again", path.string(),
             header.width, header.height);
  }
  ReadImage image = makeReadImage(header.width, header.height, usualChannels(layout.channels),
                                  layout.bytes == 2 ? ChannelType::Unorm16 : ChannelType::Unorm8, path);
  std::vector<uint16_t> storage((size + 1) / 2);
  check(spng_decode_image(context.get(), storage.data(), size, layout.format, SPNG_DECODE_TRNS));
  check(spng_decode_chunks(context.get()));  // read to the end: a truncated file may still contain all pixels
  const auto* narrow = reinterpret_cast<const uint8_t*>(storage.data());
  for (size_t c = 0; c < layout.channels; ++c) {
    std::vector<double>& values = image.channels[c].values;
    for (size_t i = 0; i < pixels; ++i) {
      const size_t at = i * layout.channels + c;
      values[i] = layout.bytes == 2 ? storage[at] / 65535.0 : narrow[at] / 255.0;
    }
  }
  return image;
}

}  // namespace latelight::output
