// Canonical Huffman decoding, and the code length format of BasisLZ.
#include "scene/textures/huffman.h"

namespace latelight::scene {
namespace {

// The symbols with which code lengths are stored: a length from 0 to 16, or one of these runs.
constexpr uint32_t kRunSymbols = 21, kShortZeros = 17, kLongZeros = 18, kShortRepeat = 19, kLongRepeat = 20;

struct Run {
  uint32_t bits, least;
  bool repeats;  // repeats the previous length; otherwise zeros
};
constexpr Run kRuns[] = {{3, 3, false}, {7, 11, false}, {2, 3, true}, {7, 7, true}};
static_assert(kLongZeros == kShortZeros + 1 && kShortRepeat == kShortZeros + 2 && kLongRepeat == kShortZeros + 3);

HuffmanTable readLengthTable(BitReader& reader) {
  constexpr uint8_t kOrder[kRunSymbols] = {17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16};
  const uint32_t stored = reader.bits(5);
  if (stored < 1 || stored > kRunSymbols) throw BrokenTexture("a Huffman table has no valid lengths");
  std::array<uint8_t, kRunSymbols> lengths{};
  for (uint32_t i = 0; i < stored; ++i) lengths[kOrder[i]] = uint8_t(reader.bits(3));
  return HuffmanTable(lengths);
}

}  // namespace

HuffmanTable::HuffmanTable(std::span<const uint8_t> lengths) {
  for (uint8_t length : lengths) ++counts_[length];
  counts_[0] = 0;
  // A code of n bits occupies 2^-n of the code space.
  int64_t left = 1;
  std::array<uint32_t, kLongest + 1> next{};
  for (size_t length = 1; length <= kLongest; ++length) {
    left = 2 * left - counts_[length];
    if (left < 0) throw BrokenTexture("a Huffman table has more codes than there can be");
    next[length] = next[length - 1] + counts_[length - 1];
  }
  symbols_.resize(next[kLongest] + counts_[kLongest]);
  for (size_t symbol = 0; symbol < lengths.size(); ++symbol)
    if (lengths[symbol] > 0) symbols_[next[lengths[symbol]]++] = uint16_t(symbol);
}

uint32_t HuffmanTable::decode(BitReader& reader) const {
  // Codes of one length are consecutive numbers that follow those of the previous length.
  uint32_t code = 0, first = 0, place = 0;
  for (size_t length = 1; length <= kLongest; ++length) {
    code = code << 1 | reader.bit();
    first <<= 1;
    if (code - first < counts_[length]) return symbols_[place + code - first];
    place += counts_[length];
    first += counts_[length];
  }
  throw BrokenTexture("it has a code that its Huffman table has not");
}

HuffmanTable readHuffmanTable(BitReader& reader) {
  const uint32_t count = reader.bits(14);
  if (count == 0) return {};
  const HuffmanTable table = readLengthTable(reader);
  std::vector<uint8_t> lengths;
  while (lengths.size() < count) {
    const uint32_t symbol = table.decode(reader);
    if (symbol < kShortZeros) {
      lengths.push_back(uint8_t(symbol));
      continue;
    }
    const Run& run = kRuns[symbol - kShortZeros];
    const uint8_t repeated = run.repeats && !lengths.empty() ? lengths.back() : uint8_t{0};
    if (run.repeats && repeated == 0) throw BrokenTexture("a Huffman table repeats a length before it has one");
    lengths.insert(lengths.end(), run.least + reader.bits(run.bits), repeated);
  }
  if (lengths.size() > count) throw BrokenTexture("a Huffman table has more lengths than symbols");
  return HuffmanTable(lengths);
}

}  // namespace latelight::scene
