// The PNG encoder. It compresses stripes of rows in parallel and concatenates them to one zlib stream, with one IDAT
// chunk per stripe. A stripe is produced, filtered and compressed in blocks of rows that stay in the processor's cache.
#include "output/png.h"

#include <isa-l/crc.h>
#include <isa-l/igzip_lib.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <memory>
#include <string_view>

#include "base/parallel.h"
#include "output/deflate.h"

namespace latelight::output {
namespace {

// Raw bytes that one thread compresses. The number is fixed, so that the file does not depend on the number of threads,
// and large enough that restarting compression costs less than 1 % of the size.
constexpr size_t kStripeBytes = size_t{2} << 20;
// It produced the smallest files of the fixed filters, and vectorizes.
constexpr uint8_t kFilterUp = 2;

void putBigEndian(std::vector<std::byte>& out, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::byte>(value >> shift));
}

const uint8_t* bytesOf(const std::byte* bytes) {
  return reinterpret_cast<const uint8_t*>(bytes);
}

constexpr size_t kChunkBytes = 12;  // overhead of a chunk

void putChunk(std::vector<std::byte>& out, const char (&type)[5], std::span<const std::byte> data) {
  putBigEndian(out, static_cast<uint32_t>(data.size()));
  const size_t begin = out.size();
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::byte>(type[i]));
  out.insert(out.end(), data.begin(), data.end());
  putBigEndian(out, crc32_gzip_refl(0, bytesOf(out.data() + begin), out.size() - begin));
}

// A part of the image, and of the single zlib stream that all parts form.
struct Stripe {
  std::vector<std::byte> deflated;
  size_t rawBytes = 0;
  uint32_t adler = 1;  // of no bytes
};

size_t pixelBytesOf(const PngLayout& layout) {
  return size_t{layout.channels} * layout.bits / 8;
}

void toBigEndian16(std::byte* values, size_t bytes) {
  if constexpr (std::endian::native == std::endian::big) return;
  for (size_t i = 0; i < bytes; i += 2) {
    uint16_t value;
    std::memcpy(&value, values + i, 2);
    value = static_cast<uint16_t>(value << 8 | value >> 8);
    std::memcpy(values + i, &value, 2);
  }
}

// Writes filtered rows, each after the number of its filter. `rows` follow the row above the first of them.
void filterRows(const std::byte* rows, size_t rowBytes, size_t count, std::byte* out) {
  for (size_t y = 0; y < count; ++y, rows += rowBytes) {
    const auto* row = reinterpret_cast<const uint8_t*>(rows);
    const uint8_t* above = row - rowBytes;
    *out++ = static_cast<std::byte>(kFilterUp);
    for (size_t i = 0; i < rowBytes; ++i) out[i] = static_cast<std::byte>(row[i] - above[i]);
    out += rowBytes;
  }
}

// Makes the stripe of the rows in [begin, end).
Stripe makeStripe(const PngLayout& layout, const PngRows& rows, size_t begin, size_t end) {
  const size_t rowBytes = layout.width * pixelBytesOf(layout);
  const size_t blockRows = std::clamp<size_t>(Deflater::kBlockBytes / (rowBytes + 1), 1, end - begin);
  const auto block = std::make_unique_for_overwrite<std::byte[]>((blockRows + 1) * rowBytes);  // after the row above
  const auto filtered = std::make_unique_for_overwrite<std::byte[]>(blockRows * (rowBytes + 1));
  const auto produce = [&](size_t first, size_t last, std::byte* out) {
    rows(first, last, out);
    if (layout.bits == 16) toBigEndian16(out, (last - first) * rowBytes);
  };
  if (begin == 0)
    std::memset(block.get(), 0, rowBytes);  // the row above the first one counts as zero
  else
    produce(begin - 1, begin, block.get());
  Stripe stripe{.rawBytes = (rowBytes + 1) * (end - begin)};
  Deflater deflater(pixelBytesOf(layout));
  for (size_t y = begin; y < end; y += blockRows) {
    const size_t count = std::min(blockRows, end - y), bytes = count * (rowBytes + 1);
    produce(y, y + count, block.get() + rowBytes);
    filterRows(block.get() + rowBytes, rowBytes, count, filtered.get());
    stripe.adler = isal_adler32(stripe.adler, bytesOf(filtered.get()), bytes);
    deflater.add({filtered.get(), bytes}, y + count == layout.height);
    std::memcpy(block.get(), block.get() + count * rowBytes, rowBytes);
  }
  if (end < layout.height) deflater.alignToByte();
  stripe.deflated = std::move(deflater.output());
  return stripe;
}

std::vector<Stripe> deflatePicture(const PngLayout& layout, const PngRows& rows) {
  const size_t height = layout.height, rowBytes = layout.width * pixelBytesOf(layout);
  const size_t stripeRows = std::max<size_t>(1, kStripeBytes / (rowBytes + 1));
  std::vector<Stripe> stripes((height + stripeRows - 1) / stripeRows);
  parallelFor(stripes.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      stripes[i] = makeStripe(layout, rows, i * stripeRows, std::min(height, (i + 1) * stripeRows));
  });
  return stripes;
}

// Writes one IDAT chunk per stripe. The zlib header precedes the first stripe, and the checksum follows the last.
void putPixels(std::vector<std::byte>& out, std::vector<Stripe> stripes) {
  constexpr std::byte kZlibHeader[] = {std::byte{0x78}, std::byte{0x01}};  // 32 KiB window, fastest level
  uLong adler = 1;                                                         // of no bytes
  for (const Stripe& stripe : stripes) {
    adler = adler32_combine(adler, stripe.adler, static_cast<z_off_t>(stripe.rawBytes));
  }
  putBigEndian(stripes.back().deflated, static_cast<uint32_t>(adler));
  std::vector<std::byte>& first = stripes.front().deflated;
  first.insert(first.begin(), std::begin(kZlibHeader), std::end(kZlibHeader));
  size_t bytes = out.size();
  for (const Stripe& stripe : stripes) bytes += stripe.deflated.size() + kChunkBytes;
  out.reserve(bytes + kChunkBytes);  // including IEND
  for (Stripe& stripe : stripes) {
    putChunk(out, "IDAT", stripe.deflated);
    stripe = Stripe();  // frees the stripe, so that a large file is in memory only once
  }
}

std::vector<std::byte> imageHeader(const PngLayout& layout) {
  constexpr uint8_t kColorTypes[] = {0, 4, 2, 6};
  std::vector<std::byte> header;
  putBigEndian(header, layout.width);
  putBigEndian(header, layout.height);
  for (const uint32_t value : {layout.bits, uint32_t{kColorTypes[layout.channels - 1]}, 0u, 0u, 0u}) {
    header.push_back(static_cast<std::byte>(value));  // the zeros mean deflate, the five filters, not interlaced
  }
  return header;
}

}  // namespace

std::vector<std::byte> encodePng(const PngLayout& layout, const PngRows& rows) {
  assert(layout.width > 0 && layout.height > 0 && layout.channels >= 1 && layout.channels <= 4 &&
         (layout.bits == 8 || layout.bits == 16));
  constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
  std::vector<std::byte> out;
  for (const char byte : kSignature) out.push_back(static_cast<std::byte>(byte));
  putChunk(out, "IHDR", imageHeader(layout));
  constexpr std::byte kRelativeColorimetric[] = {std::byte{1}};
  if (layout.light == PngLight::Srgb) putChunk(out, "sRGB", kRelativeColorimetric);
  putPixels(out, deflatePicture(layout, rows));
  putChunk(out, "IEND", {});
  return out;
}

std::vector<std::byte> encodePng(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits,
                                 const std::byte* pixels, PngLight light) {
  const PngLayout layout{width, height, channels, bits, light};
  const size_t rowBytes = width * pixelBytesOf(layout);
  return encodePng(layout, [&](size_t begin, size_t end, std::byte* out) {
    std::memcpy(out, pixels + begin * rowBytes, (end - begin) * rowBytes);
  });
}

std::vector<std::byte> encodePng(const Picture& picture) {
  assert(picture.rgba.size() == size_t{picture.width} * picture.height * 4);
  return encodePng(picture.width, picture.height, 4, 8, reinterpret_cast<const std::byte*>(picture.rgba.data()),
                   PngLight::Srgb);
}

}  // namespace latelight::output
