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
  HuffmanTable() = default;  // an empty table
  // Builds the table from the length of each symbol's code; 0: no code. Throws BrokenTexture if no code has these
  // lengths.
  explicit HuffmanTable(std::span<const uint8_t> lengths);

  // Returns the next symbol. Throws BrokenTexture if no symbol has the following code.
  uint32_t decode(BitReader& reader) const;

 private:
  static constexpr size_t kLongest = 16;
  std::array<uint32_t, kLongest + 1> counts_{};  // number of codes, by length
  std::vector<uint16_t> symbols_;                // in code order
};

// Reads a table as BasisLZ stores it (KTX 2.0, "Compressed Huffman Tables").
HuffmanTable readHuffmanTable(BitReader& reader);

}  // namespace latelight::scene
