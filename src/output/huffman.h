// Huffman codes of limited length, as deflate requires them (RFC 1951, section 3.2.2).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace latelight::output {

// No code is longer, so that four codes and a partial byte fit into 64 bits.
constexpr uint32_t kMaxCodeBits = 12;

struct HuffmanCode {
  uint16_t code = 0;  // the first bit is the lowest
  uint16_t bits = 0;  // 0: the symbol does not occur
};

// Computes the codes of symbols that occur `counts` times. At least one count must not be zero, and there are at most
// 512 symbols.
void makeHuffmanCodes(std::span<const uint32_t> counts, std::span<HuffmanCode> codes);

}  // namespace latelight::output
