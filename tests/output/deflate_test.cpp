#include "output/deflate.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <random>

namespace latelight::output {
namespace {

using Bytes = std::vector<std::byte>;

// zlib's decoder. windowBits: 15 for a zlib stream, -15 for raw deflate.
Bytes inflated(const Bytes& deflated, size_t size, int windowBits) {
  Bytes out(size + 1);
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, windowBits), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(deflated.data()));
  stream.avail_in = static_cast<uInt>(deflated.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(::inflate(&stream, Z_FINISH), Z_STREAM_END);
  EXPECT_EQ(stream.avail_in, 0u);
  out.resize(stream.total_out);
  inflateEnd(&stream);
  return out;
}

// Bytes of which `different` values occur: 256 are incompressible.
Bytes bytesOf(size_t size, uint32_t different) {
  std::mt19937 random(static_cast<uint32_t>(size) + different);
  Bytes bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() % different);
  return bytes;
}

// Pixels that repeat up to `longest` times, with a few bytes between them that shift the following pixels.
Bytes runsOf(size_t size, size_t pixelBytes, uint32_t longest) {
  std::mt19937 random(static_cast<uint32_t>(size + pixelBytes) + longest);
  Bytes bytes;
  while (bytes.size() < size) {
    const Bytes pixel = bytesOf(pixelBytes + random() % 2, 1 + random() % 256);
    for (uint32_t i = random() % longest; i < longest; ++i) bytes.insert(bytes.end(), pixel.begin(), pixel.end());
  }
  bytes.resize(size);
  return bytes;
}

// Sizes around those of words, matches and blocks.
constexpr size_t kSizes[] = {0, 1, 2, 7, 8, 9, 100, 257, 258, 259, 262, 65'536, 262'143, 262'144, 1'000'003, 5'000'000};
constexpr size_t kPixelBytes[] = {1, 2, 3, 4, 5, 6, 8, 12, 16, 255, 32'768};

TEST(Deflate, StreamsAreThoseOfZlib) {
  for (const size_t size : kSizes)
    for (const uint32_t different : {1u, 3u, 256u}) {
      SCOPED_TRACE(testing::Message() << size << " bytes of " << different << " values");
      const Bytes bytes = bytesOf(size, different);
      EXPECT_TRUE(inflated(deflateZlib(bytes, 4), size, 15) == bytes);
    }
}

TEST(Deflate, RunsOfPixelsComeBack) {
  for (const size_t pixelBytes : kPixelBytes)
    for (const uint32_t longest : {1u, 3u, 9u, 70u, 1000u})
      for (const size_t size : {100, 5000, 300'000}) {
        SCOPED_TRACE(testing::Message() << size << " bytes, pixels of " << pixelBytes << ", runs to " << longest);
        const Bytes bytes = runsOf(size, pixelBytes, longest);
        EXPECT_TRUE(inflated(deflateZlib(bytes, pixelBytes), size, 15) == bytes);
      }
}

Bytes partOf(const Bytes& bytes, bool last) {
  Deflater deflater(4);
  deflater.add(bytes, last);
  if (!last) deflater.alignToByte();
  return deflater.output();
}

TEST(Deflate, PartsFormOneStream) {
  for (const size_t first : kSizes)
    for (const size_t second : {size_t{0}, size_t{70'000}})
      for (const uint32_t different : {1u, 3u, 256u}) {
        SCOPED_TRACE(testing::Message() << first << " and " << second << " bytes of " << different << " values");
        Bytes bytes = bytesOf(first, different), deflated = partOf(bytes, false);
        const Bytes more = bytesOf(second, different), rest = partOf(more, true);
        bytes.insert(bytes.end(), more.begin(), more.end());
        deflated.insert(deflated.end(), rest.begin(), rest.end());
        EXPECT_TRUE(inflated(deflated, bytes.size(), -15) == bytes);
      }
}

// Blocks of every number of bits continue where the one before ends, within a byte.
TEST(Deflate, BlocksFollowWithinAByte) {
  Deflater deflater(1);
  Bytes all;
  for (size_t size = 0; size < 200; ++size) {
    const Bytes bytes = bytesOf(size, 1 + static_cast<uint32_t>(size));
    deflater.add(bytes, false);
    all.insert(all.end(), bytes.begin(), bytes.end());
  }
  deflater.add({}, true);
  EXPECT_TRUE(inflated(deflater.output(), all.size(), -15) == all);
}

TEST(Deflate, Compresses) {
  EXPECT_LT(deflateZlib(bytesOf(1'000'000, 1), 1).size(), 2'000u);        // 258 bytes in 2 bits
  EXPECT_LT(deflateZlib(bytesOf(1'000'000, 4), 1).size(), 300'000u);      // with its end, 5 symbols: 2.25 bits per byte
  EXPECT_LT(deflateZlib(bytesOf(1'000'000, 256), 1).size(), 1'001'500u);  // a code of 8 bits, and headers
  Bytes pixels = bytesOf(600'000, 256);
  for (size_t i = 6; i < pixels.size(); ++i)
    if (i / 6 % 1000 != 0) pixels[i] = pixels[i - 6];  // 100 runs of 1000 pixels
  EXPECT_LT(deflateZlib(pixels, 6).size(), 100u * (6 + 6000 / 258 + 3) + 1000);
}

}  // namespace
}  // namespace latelight::output
