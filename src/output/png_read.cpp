#include <spng.h>

#include <memory>

#include "base/error.h"
#include "output/decode.h"
#include "output/png.h"

namespace latelight::output {
namespace {

struct Layout {
  spng_format format;
  uint32_t channels, bytes;
};

// What libspng is to decode to: palettes, less than 8 bits and transparent colours are expanded.
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

}  // namespace

ReadImage decodePng(std::span<const std::byte> bytes, const std::filesystem::path& path) {
  const auto check = [&](int result) {
    if (result != SPNG_OK) {
      badInput("can't read '{}' as PNG: {}; make or download it again", path.string(), spng_strerror(result));
    }
  };
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> context(spng_ctx_new(0), spng_ctx_free);
  if (!context) throw std::bad_alloc();
  check(spng_set_png_buffer(context.get(), bytes.data(), bytes.size()));
  spng_ihdr header{};
  check(spng_get_ihdr(context.get(), &header));
  const Layout layout = layoutOf(context.get(), header);
  ReadImage image = makeReadImage(header.width, header.height, usualChannels(layout.channels),
                                  layout.bytes == 2 ? ChannelType::Unorm16 : ChannelType::Unorm8, path);
  const size_t pixels = size_t{header.width} * header.height;
  std::vector<uint16_t> storage((pixels * layout.channels * layout.bytes + 1) / 2);
  size_t size = 0;
  check(spng_decoded_image_size(context.get(), layout.format, &size));
  if (size != pixels * layout.channels * layout.bytes) {
    badInput("can't read '{}' as PNG: its rows have an unexpected size; save it as 8 or 16 bit RGBA", path.string());
  }
  check(spng_decode_image(context.get(), storage.data(), size, layout.format, 0));
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
