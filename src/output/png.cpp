// The PNG encoder. It filters and compresses stripes of rows in parallel and concatenates them to one zlib stream, with
// one IDAT chunk per stripe.
#include "output/png.h"

#include <isa-l/crc.h>
#include <isa-l/igzip_lib.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <memory>
#include <new>
#include <string_view>

#include "base/parallel.h"
#include "output/deflate.h"

namespace latelight::output {
namespace {

// Raw bytes that one thread filters and compresses. The number is fixed, so that the file does not depend on the number
// of threads, and large enough that restarting compression costs less than 1 % of the size.
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
  uLong adler = 0;
};

// Writes the filtered rows, each after the number of its filter.
void filterRows(const std::byte* pixels, size_t rowBytes, size_t begin, size_t end, std::byte* out) {
  for (size_t y = begin; y < end; ++y) {
    const auto* row = reinterpret_cast<const uint8_t*>(pixels + y * rowBytes);
    *out++ = static_cast<std::byte>(kFilterUp);
    if (y == 0) {
      std::memcpy(out, row, rowBytes);  // the row above the first one counts as zero
    } else {
      const uint8_t* above = row - rowBytes;
      for (size_t i = 0; i < rowBytes; ++i) out[i] = static_cast<std::byte>(row[i] - above[i]);
    }
    out += rowBytes;
  }
}

// Makes the stripe of the rows in [begin, end).
Stripe makeStripe(const std::byte* pixels, size_t rowBytes, size_t begin, size_t end, bool last) {
  Stripe stripe{.rawBytes = (rowBytes + 1) * (end - begin)};
  const auto raw = std::make_unique_for_overwrite<std::byte[]>(stripe.rawBytes);
  filterRows(pixels, rowBytes, begin, end, raw.get());
  stripe.adler = isal_adler32(1, bytesOf(raw.get()), stripe.rawBytes);
  stripe.deflated = deflate({raw.get(), stripe.rawBytes}, last ? DeflateForm::LastPart : DeflateForm::Part);
  return stripe;
}

std::vector<Stripe> deflatePicture(const std::byte* pixels, size_t rowBytes, size_t height) {
  const size_t rows = std::max<size_t>(1, kStripeBytes / (rowBytes + 1));
  std::vector<Stripe> stripes((height + rows - 1) / rows);
  parallelFor(stripes.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      stripes[i] = makeStripe(pixels, rowBytes, i * rows, std::min(height, (i + 1) * rows), i + 1 == stripes.size());
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

std::vector<std::byte> imageHeader(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits) {
  constexpr uint8_t kColorTypes[] = {0, 4, 2, 6};
  std::vector<std::byte> header;
  putBigEndian(header, width);
  putBigEndian(header, height);
  for (const uint32_t value : {bits, uint32_t{kColorTypes[channels - 1]}, 0u, 0u, 0u}) {
    header.push_back(static_cast<std::byte>(value));  // the zeros mean deflate, the five filters, not interlaced
  }
  return header;
}

std::vector<std::byte> bigEndian16(const std::byte* pixels, size_t count) {
  std::vector<std::byte> swapped(count * 2);
  for (size_t i = 0; i < count; ++i) {
    uint16_t value;
    std::memcpy(&value, pixels + 2 * i, 2);
    swapped[2 * i] = static_cast<std::byte>(value >> 8);
    swapped[2 * i + 1] = static_cast<std::byte>(value & 0xff);
  }
  return swapped;
}

}  // namespace

std::vector<std::byte> encodePng(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits,
                                 const std::byte* pixels, PngLight light) {
  assert(width > 0 && height > 0 && channels >= 1 && channels <= 4 && (bits == 8 || bits == 16));
  const size_t rowBytes = size_t{width} * channels * (bits / 8);
  std::vector<std::byte> swapped;
  if (bits == 16 && std::endian::native == std::endian::little) {
    swapped = bigEndian16(pixels, size_t{width} * height * channels);
    pixels = swapped.data();
  }
  constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
  std::vector<std::byte> out;
  for (const char byte : kSignature) out.push_back(static_cast<std::byte>(byte));
  putChunk(out, "IHDR", imageHeader(width, height, channels, bits));
  constexpr std::byte kRelativeColorimetric[] = {std::byte{1}};
  if (light == PngLight::Srgb) putChunk(out, "sRGB", kRelativeColorimetric);
  putPixels(out, deflatePicture(pixels, rowBytes, height));
  putChunk(out, "IEND", {});
  return out;
}

std::vector<std::byte> encodePng(const Picture& picture) {
  assert(picture.rgba.size() == size_t{picture.width} * picture.height * 4);
  return encodePng(picture.width, picture.height, 4, 8, reinterpret_cast<const std::byte*>(picture.rgba.data()),
                   PngLight::Srgb);
}

}  // namespace latelight::output
