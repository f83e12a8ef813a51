// Compression of arrays of pixels to deflate (RFC 1951): repeats of the previous pixel, and Huffman codes for the rest.
//
// Writing data sets is bound by compression. A match may only repeat the previous pixel, so that matches are found by
// comparing the data with itself, shifted by a pixel, without a hash table. Filtered rows of rendered images are noise
// and constant areas: they have few other matches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace latelight::output {

// Compresses to raw deflate. The result depends on the arguments alone, not on the processor.
class Deflater {
 public:
  // The number of bytes that should be compressed together. Each call of add() has its own Huffman codes, whose
  // description requires about a hundred bytes.
  static constexpr size_t kBlockBytes = size_t{1} << 18;

  explicit Deflater(size_t pixelBytes) : pixelBytes_(pixelBytes) {}  // 1 to 32768

  // Compresses bytes that follow those of the previous call. They begin at a pixel.
  void add(std::span<const std::byte> bytes, bool last);
  // Ends on a byte boundary, after which another stream may follow, as in pigz (Z_SYNC_FLUSH of zlib).
  void alignToByte();

  std::vector<std::byte>& output() { return output_; }

 private:
  size_t pixelBytes_;
  uint64_t bits_ = 0;  // at the end of the output, which do not fill a byte
  uint32_t bitCount_ = 0;
  std::vector<std::byte> output_;
  std::unique_ptr<std::byte[]> block_;  // the compressed block, before its size is known
  size_t blockCapacity_ = 0;
};

// Returns a zlib stream (RFC 1950).
std::vector<std::byte> deflateZlib(std::span<const std::byte> bytes, size_t pixelBytes);

}  // namespace latelight::output
