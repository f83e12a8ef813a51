#include "output/deflate.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <memory>
#include <random>
#include <span>

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

// Sizes around those of stored blocks, and of stripes of PNG files.
constexpr size_t kSizes[] = {0, 1, 2, 100, 65'534, 65'535, 65'536, 131'071, 1'000'003, 2'097'152, 5'000'000};

TEST(Deflate, StreamsAreThoseOfZlib) {
  for (const size_t size : kSizes)
    for (const uint32_t different : {1u, 3u, 256u}) {
      SCOPED_TRACE(testing::Message() << size << " bytes of " << different << " values");
      const Bytes bytes = bytesOf(size, different);
      EXPECT_TRUE(inflated(deflate(bytes, DeflateForm::Zlib), size, 15) == bytes);
    }
}

TEST(Deflate, PartsFormOneStream) {
  for (const size_t first : kSizes)
    for (const size_t second : {size_t{0}, size_t{70'000}})
      for (const uint32_t different : {1u, 3u, 256u}) {
        SCOPED_TRACE(testing::Message() << first << " and " << second << " bytes of " << different << " values");
        Bytes bytes = bytesOf(first, different), deflated = deflate(bytes, DeflateForm::Part);
        const Bytes more = bytesOf(second, different), rest = deflate(more, DeflateForm::LastPart);
        bytes.insert(bytes.end(), more.begin(), more.end());
        deflated.insert(deflated.end(), rest.begin(), rest.end());
        EXPECT_TRUE(inflated(deflated, bytes.size(), -15) == bytes);
      }
}

TEST(Deflate, Compresses) {
  EXPECT_LT(deflate(bytesOf(1'000'000, 1), DeflateForm::Zlib).size(), 10'000u);
  EXPECT_LT(deflate(bytesOf(1'000'000, 4), DeflateForm::Zlib).size(), 330'000u);
  EXPECT_LT(deflate(bytesOf(1'000'000, 256), DeflateForm::Zlib).size(), 1'000'200u);
}

// ISA-L hashes the address of its stream together with the data, and the smaller the data is, the more often that
// changes the result: without the choice of an address, 3 % of those that hold these 20 bytes.
TEST(Deflate, BytesDoNotDependOnTheAddress) {
  constexpr size_t kRange = size_t{64} << 20, kStep = size_t{1} << 16;
  const auto memory = std::make_unique_for_overwrite<std::byte[]>(kRange);
  for (const size_t size : {20, 33, 50, 100, 200, 400}) {
    Bytes rows(size);  // like filtered rows of a transparent image
    for (size_t i = 0; i < size; i += 129) rows[i] = std::byte{2};
    const Bytes expected = deflate(rows, DeflateForm::LastPart);
    size_t others = 0;
    for (size_t at = 0; at + kDeflateWorkspace <= kRange; at += kStep) {
      const std::span<std::byte, kDeflateWorkspace> workspace(memory.get() + at, kDeflateWorkspace);
      others += deflate(rows, DeflateForm::LastPart, workspace) != expected;
    }
    EXPECT_EQ(others, 0u) << size << " bytes";
  }
}

}  // namespace
}  // namespace latelight::output
