#include "output/huffman.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace latelight::output {
namespace {

constexpr uint32_t kSymbolBits = 9;
constexpr size_t kMaxSymbols = size_t{1} << kSymbolBits;
using Leaves = std::array<uint32_t, kMaxSymbols>;  // count and symbol, in the order of counts
using LengthCounts = std::array<uint32_t, kMaxCodeBits + 1>;

size_t sortLeaves(std::span<const uint32_t> counts, Leaves& leaves) {
  constexpr uint32_t kMaxCount = (uint32_t{1} << (32 - kSymbolBits)) - 1;
  size_t used = 0;
  for (uint32_t symbol = 0; symbol < counts.size(); ++symbol)
    if (counts[symbol] > 0) leaves[used++] = std::min(counts[symbol], kMaxCount) << kSymbolBits | symbol;
  std::sort(leaves.begin(), leaves.begin() + used);
  return used;
}

// Builds Huffman's tree from two queues, the leaves and the inner nodes, which are both in the order of their weights,
// and returns how many leaves have each depth. Deeper leaves count as the deepest allowed.
LengthCounts countLengths(const Leaves& leaves, size_t used) {
  std::array<uint64_t, 2 * kMaxSymbols> weights;
  std::array<uint16_t, 2 * kMaxSymbols> parents, depths;
  for (size_t i = 0; i < used; ++i) weights[i] = leaves[i] >> kSymbolBits;
  size_t leaf = 0, inner = used, next = used;
  const auto takeLightest = [&] {
    const bool isLeaf = leaf < used && (inner == next || weights[leaf] <= weights[inner]);
    return isLeaf ? leaf++ : inner++;
  };
  for (; next < 2 * used - 1; ++next) {
    const size_t a = takeLightest(), b = takeLightest();
    weights[next] = weights[a] + weights[b];
    parents[a] = parents[b] = static_cast<uint16_t>(next);
  }
  LengthCounts lengths{};
  depths[2 * used - 2] = 0;
  for (size_t i = 2 * used - 2; i-- > 0;) {
    depths[i] = static_cast<uint16_t>(depths[parents[i]] + 1);
    if (i < used) ++lengths[std::min<uint32_t>(depths[i], kMaxCodeBits)];
  }
  return lengths;
}

// Lengthens codes until they are a prefix code again (Kraft's inequality): a leaf moves down, and one of the deepest
// becomes its sibling.
void repairLengths(LengthCounts& lengths) {
  uint64_t space = 0;  // in units of the longest code
  for (uint32_t bits = 1; bits <= kMaxCodeBits; ++bits) space += uint64_t{lengths[bits]} << (kMaxCodeBits - bits);
  for (; space > uint64_t{1} << kMaxCodeBits; --space) {
    uint32_t bits = kMaxCodeBits - 1;
    while (lengths[bits] == 0) --bits;
    --lengths[bits];
    lengths[bits + 1] += 2;
    --lengths[kMaxCodeBits];
  }
}

uint16_t reversed(uint32_t code, uint32_t bits) {
  uint32_t result = 0;
  for (uint32_t i = 0; i < bits; ++i) result |= (code >> i & 1) << (bits - 1 - i);
  return static_cast<uint16_t>(result);
}

// Codes of the same length are consecutive, in the order of the symbols.
void assignCodes(const LengthCounts& lengths, std::span<HuffmanCode> codes) {
  LengthCounts next{};
  for (uint32_t bits = 2; bits <= kMaxCodeBits; ++bits) next[bits] = (next[bits - 1] + lengths[bits - 1]) << 1;
  for (HuffmanCode& code : codes)
    if (code.bits > 0) code.code = reversed(next[code.bits]++, code.bits);
}

}  // namespace

void makeHuffmanCodes(std::span<const uint32_t> counts, std::span<HuffmanCode> codes) {
  assert(counts.size() == codes.size() && counts.size() <= kMaxSymbols);
  Leaves leaves;
  const size_t used = sortLeaves(counts, leaves);
  assert(used > 0);
  LengthCounts lengths{};
  if (used == 1) {
    lengths[1] = 1;
  } else {
    lengths = countLengths(leaves, used);
    repairLengths(lengths);
  }
  std::fill(codes.begin(), codes.end(), HuffmanCode{});
  size_t leaf = 0;  // the rarest symbols have the longest codes
  for (uint32_t bits = kMaxCodeBits; bits > 0; --bits)
    for (uint32_t i = 0; i < lengths[bits]; ++i) codes[leaves[leaf++] % kMaxSymbols].bits = static_cast<uint16_t>(bits);
  assignCodes(lengths, codes);
}

}  // namespace latelight::output
