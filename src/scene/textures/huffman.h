// Canonical Huffman codes as in Deflate (RFC 1951, 3.2.2), with codes of up to 16 bits.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/textures/bits.h"

namespace latelight::scene {

class HuffmanTable {
 public:
  HuffmanTable() = default;  // of no symbols
  // From the length of each symbol's code; 0: it has none. Throws BrokenTexture if no code has these lengths.
  explicit HuffmanTable(std::span<const uint8_t> lengths);

  // Throws BrokenTexture if no symbol has the code that follows.
  uint32_t decode(BitReader& reader) const;

 private:
  static constexpr size_t kLongest = 16;
  std::array<uint32_t, kLongest + 1> counts_{};  // of codes, by their length
  std::vector<uint16_t> symbols_;                // in the order of their codes
};

// A table as BasisLZ stores it (KTX 2.0, "Compressed Huffman Tables").
HuffmanTable readHuffmanTable(BitReader& reader);

}  // namespace latelight::scene
