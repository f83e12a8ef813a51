// The PNG encoder. It filters and compresses stripes of rows in parallel and concatenates them to one zlib stream, with
// one IDAT chunk per stripe.
#include "output/png.h"

#include <libdeflate.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <memory>
#include <new>
#include <string_view>

#include "base/parallel.h"

namespace latelight::output {
namespace {

// Images of at most this many raw bytes are compressed in one piece by libdeflate. For 640x480 images of builtin:hall
// it required 45 % of zlib's time and produced files 4 % smaller. Larger images are worth several threads, and
// libdeflate cannot end a part such that another may follow.
constexpr size_t kWholeBytes = size_t{2} << 20;
// Raw bytes that one thread filters and compresses. The number is fixed, so that the file does not depend on the number
// of threads, and large enough that restarting compression costs less than 1 % of the size.
constexpr size_t kStripeBytes = size_t{512} << 10;
// The fastest level. For 1280x720 images full of texture, level 2 required 10 % more time for 1 % fewer bytes, and
// level 6 five times the time for 4 % fewer. Filter Up produced the smallest files of the fixed filters and vectorizes.
constexpr int kLevel = 1;
constexpr uint8_t kFilterUp = 2;

void putBigEndian(std::vector<std::byte>& out, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::byte>(value >> shift));
}

const Bytef* zlibBytes(const std::byte* bytes) {
  return reinterpret_cast<const Bytef*>(bytes);
}

constexpr size_t kChunkBytes = 12;  // overhead of a chunk

void putChunk(std::vector<std::byte>& out, const char (&type)[5], std::span<const std::byte> data) {
  putBigEndian(out, static_cast<uint32_t>(data.size()));
  const size_t begin = out.size();
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::byte>(type[i]));
  out.insert(out.end(), data.begin(), data.end());
  putBigEndian(out, static_cast<uint32_t>(crc32_z(0, zlibBytes(out.data() + begin), out.size() - begin)));
}

// A part of the image, and of the single zlib stream that all parts form.
struct Stripe {
  std::vector<std::byte> deflated;
  size_t rawBytes = 0;
  uLong adler = 0;
};

std::vector<std::byte> filterRows(const std::byte* pixels, size_t rowBytes, size_t begin, size_t end) {
  std::vector<std::byte> raw((rowBytes + 1) * (end - begin));
  std::byte* out = raw.data();
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
  return raw;
}

std::vector<std::byte> deflateWhole(const std::vector<std::byte>& raw) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(kLevel), libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  std::vector<std::byte> deflated(libdeflate_deflate_compress_bound(compressor.get(), raw.size()));
  deflated.resize(
      libdeflate_deflate_compress(compressor.get(), raw.data(), raw.size(), deflated.data(), deflated.size()));
  return deflated;
}

// Compresses to raw deflate that ends on a byte boundary, so that stripes can be concatenated (as in pigz).
std::vector<std::byte> deflatePart(const std::vector<std::byte>& raw, bool last) {
  std::vector<std::byte> deflated;
  z_stream stream{};
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, -15, 9, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
  deflated.resize(deflateBound(&stream, static_cast<uLong>(raw.size())) + 16);
  stream.next_in = const_cast<Bytef*>(zlibBytes(raw.data()));
  stream.avail_in = static_cast<uInt>(raw.size());
  stream.next_out = reinterpret_cast<Bytef*>(deflated.data());
  stream.avail_out = static_cast<uInt>(deflated.size());
  [[maybe_unused]] const int result = deflate(&stream, last ? Z_FINISH : Z_SYNC_FLUSH);
  assert(result == (last ? Z_STREAM_END : Z_OK) && stream.avail_in == 0);
  deflated.resize(stream.total_out);
  deflateEnd(&stream);
  return deflated;
}

Stripe makeStripe(const std::vector<std::byte>& raw, bool first, bool last) {
  Stripe stripe{.rawBytes = raw.size()};
  stripe.adler = adler32_z(adler32_z(0, nullptr, 0), zlibBytes(raw.data()), raw.size());
  stripe.deflated = first && last ? deflateWhole(raw) : deflatePart(raw, last);
  stripe.deflated.shrink_to_fit();  // many stripes are in memory at once
  return stripe;
}

std::vector<Stripe> deflatePicture(const std::byte* pixels, size_t rowBytes, size_t height) {
  const bool whole = height * (rowBytes + 1) <= kWholeBytes;
  const size_t rows = whole ? height : std::max<size_t>(1, kStripeBytes / (rowBytes + 1));
  std::vector<Stripe> stripes((height + rows - 1) / rows);
  parallelFor(stripes.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      stripes[i] = makeStripe(filterRows(pixels, rowBytes, i * rows, std::min(height, (i + 1) * rows)), i == 0,
                              i + 1 == stripes.size());
  });
  return stripes;
}

// Writes one IDAT chunk per stripe. The zlib header precedes the first stripe, and the checksum follows the last.
void putPixels(std::vector<std::byte>& out, std::vector<Stripe> stripes) {
  constexpr std::byte kZlibHeader[] = {std::byte{0x78}, std::byte{0x01}};  // 32 KiB window, fastest level
  uLong adler = adler32_z(0, nullptr, 0);
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
