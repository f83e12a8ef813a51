// Decodes UASTC LDR blocks: reads a block's mode, partition pattern, quantized endpoints and weights, dequantizes them,
// and interpolates the endpoints per texel as ASTC does.
#include "scene/textures/uastc.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "base/parallel.h"
#include "scene/textures/bits.h"

namespace latelight::scene {
namespace {

// --- block modes -----------------------------------------------------------------------------------------------------

// The encoding of an endpoint value: a digit of that radix (1: none) above some bits.
struct Range {
  uint32_t radix, bits;
};

struct Mode {
  uint32_t codeBits, code;  // prefix code at the start of a block
  uint32_t hintBits;        // for transcoders to other formats
  uint32_t components;      // 2: luminance and alpha
  uint32_t subsets, planes;
  Range endpoints;
  uint32_t weightBits;
};

constexpr uint32_t kModes = 19, kSolidMode = 8, kOtherPairsMode = 7, kAlphaPlaneMode = 17;
constexpr Mode kMode[kModes] = {
    {4, 1, 15, 3, 1, 1, {3, 6}, 4},  {6, 53, 15, 3, 1, 1, {1, 8}, 2}, {5, 29, 15, 3, 2, 1, {1, 4}, 3},
    {5, 3, 15, 3, 3, 1, {3, 2}, 2},  {5, 19, 15, 3, 2, 1, {5, 3}, 2}, {5, 11, 15, 3, 1, 1, {1, 8}, 3},
    {5, 27, 15, 3, 1, 2, {5, 5}, 2}, {5, 7, 15, 3, 2, 1, {5, 3}, 2},  {5, 23, 0, 4, 1, 1, {1, 8}, 0},
    {5, 15, 23, 4, 2, 1, {1, 4}, 2}, {3, 2, 17, 4, 1, 1, {3, 4}, 4},  {2, 0, 17, 4, 1, 2, {3, 4}, 2},
    {3, 6, 17, 4, 1, 1, {3, 6}, 3},  {5, 31, 23, 4, 1, 2, {1, 8}, 1}, {5, 13, 23, 4, 1, 1, {1, 8}, 2},
    {7, 5, 23, 2, 1, 1, {1, 8}, 4},  {6, 21, 23, 2, 2, 1, {1, 8}, 2}, {6, 37, 23, 2, 1, 2, {1, 8}, 2},
    {4, 9, 15, 3, 1, 1, {1, 5}, 5}};

// The subset of each texel, two bits each: the ASTC partitions that BC7 has as well.
constexpr uint32_t kPairs[] = {0x50505050, 0x40404040, 0x01010101, 0x54505040, 0x05151555, 0x55545450,
                               0x00010515, 0x01051555, 0x50400000, 0x00000105, 0x55544000, 0x01155555,
                               0x00000115, 0x00005555, 0x55555500, 0x00555555, 0x55551501, 0x40545555,
                               0x00405054, 0x00004050, 0x15050100, 0x50545555, 0x15050501, 0x00404050,
                               0x50545455, 0x14141414, 0x55000055, 0x11111111, 0x00550055, 0x05145041};
constexpr uint32_t kOtherPairs[] = {0x00005500, 0x10101010, 0x00010505, 0x50504000, 0x55005555, 0x04040404, 0x55555040,
                                    0x50505054, 0x05500005, 0x00005454, 0x15150000, 0x05000005, 0x00005054, 0x55554000,
                                    0x14555555, 0x01050505, 0x01015555, 0x01051450, 0x00005455};
constexpr uint32_t kTriples[] = {0xa5a50000, 0xaa005555, 0xaa000055, 0x0000aa55, 0x25252525, 0x94949494,
                                 0x58585858, 0x56560202, 0x92929292, 0x55aa0055, 0xa05050a0};

// The mode for each value of a block's first seven bits; kModes if invalid.
constexpr std::array<uint8_t, 128> kModeOf = [] {
  std::array<uint8_t, 128> modes{};
  modes.fill(kModes);
  for (uint32_t mode = 0; mode < kModes; ++mode)
    for (uint32_t start = kMode[mode].code; start < 128; start += 1u << kMode[mode].codeBits)
      modes[start] = uint8_t(mode);
  return modes;
}();

// Digits are stored in groups, each as one number: five of radix 3 in 8 bits, three of radix 5 in 7.
constexpr uint32_t digitsPerGroup(uint32_t radix) {
  return radix == 3 ? 5 : 3;
}
constexpr uint32_t groupBits(uint32_t radix, uint32_t digits) {
  uint32_t values = 1;
  for (uint32_t i = 0; i < digits; ++i) values *= radix;
  return uint32_t(std::bit_width(values - 1));
}

// --- decoding a block ------------------------------------------------------------------------------------------------

class BlockBits {
 public:
  explicit BlockBits(const std::byte* block) {
    for (size_t i = 0; i < 16; ++i) words_[i / 8] |= uint64_t(block[i]) << (i % 8 * 8);
  }
  uint32_t take(uint32_t count) {
    if (count == 0) return 0;
    const auto value = uint32_t(words_[0] & ((uint64_t{1} << count) - 1));
    words_[0] = words_[0] >> count | words_[1] << (64 - count);
    words_[1] >>= count;
    return value;
  }
  uint32_t peek() const { return uint32_t(words_[0]); }

 private:
  uint64_t words_[2] = {};
};

using Texels = std::array<std::array<uint8_t, 4>, 16>;

uint32_t takePattern(const Mode& mode, bool otherPairs, BlockBits& bits) {
  if (mode.subsets == 1) return 0;
  const std::span<const uint32_t> patterns = mode.subsets == 3 ? std::span<const uint32_t>(kTriples)
                                             : otherPairs      ? std::span<const uint32_t>(kOtherPairs)
                                                               : std::span<const uint32_t>(kPairs);
  const uint32_t index = bits.take(mode.subsets == 3 ? 4 : 5);
  if (index >= patterns.size()) throw BrokenTexture("a block has a pattern that does not exist");
  return patterns[index];
}

// Returns the value's bits without the lowest one, repeated to fill 9 bits (Khronos Data Format 1.3, 23.13).
uint32_t repeated(Range range, uint32_t x) {
  if (range.radix == 3) return range.bits == 2 ? x * 0x116 : range.bits == 4 ? x << 6 | x : x << 4 | x >> 4;
  return range.bits == 3 ? x << 7 | x << 1 | x >> 1 : x << 5 | x >> 3;
}

uint8_t unquantized(Range range, uint32_t digit, uint32_t low) {
  if (range.radix == 1) {
    uint32_t value = low << (8 - range.bits);
    for (uint32_t filled = range.bits; filled < 8; filled *= 2) value |= value >> filled;
    return uint8_t(value);
  }
  constexpr uint32_t kTritFactor[] = {0, 204, 93, 44, 22, 11, 5}, kQuintFactor[] = {0, 113, 54, 26, 13, 6};
  const uint32_t factor = range.radix == 3 ? kTritFactor[range.bits] : kQuintFactor[range.bits];
  const uint32_t flip = low & 1 ? 0x1ff : 0;
  const uint32_t value = (digit * factor + repeated(range, low >> 1)) ^ flip;
  return uint8_t((flip & 0x80) | value >> 2);
}

// Reads endpoints: pairs, low and high, of each component of each subset.
std::array<uint8_t, 18> takeEndpoints(const Mode& mode, BlockBits& bits) {
  const Range range = mode.endpoints;
  const uint32_t count = 2 * mode.components * mode.subsets;
  uint32_t digits[18] = {};
  if (range.radix > 1) {
    const uint32_t group = digitsPerGroup(range.radix);
    for (uint32_t first = 0; first < count; first += group) {
      const uint32_t size = std::min(group, count - first);
      uint32_t all = bits.take(groupBits(range.radix, size));
      for (uint32_t i = 0; i < size; ++i, all /= range.radix) digits[first + i] = all % range.radix;
    }
  }
  std::array<uint8_t, 18> values{};
  for (uint32_t i = 0; i < count; ++i) values[i] = unquantized(range, digits[i], bits.take(range.bits));
  return values;
}

// Weights in units of 1/64. The highest bit of each subset's first texel is 0 and not stored.
struct Weights {
  uint8_t of[16][2];
};

Weights takeWeights(const Mode& mode, uint32_t pattern, BlockBits& bits) {
  Weights weights{};
  bool seen[3] = {};
  for (uint32_t texel = 0; texel < 16; ++texel) {
    bool& known = seen[pattern >> (2 * texel) & 3];
    for (uint32_t plane = 0; plane < mode.planes; ++plane) {
      uint32_t value = bits.take(mode.weightBits - !known) << (6 - std::min(6u, mode.weightBits));
      for (uint32_t filled = mode.weightBits; filled < 6; filled *= 2) value |= value >> filled;
      weights.of[texel][plane] = uint8_t(value + (value > 32));
    }
    known = true;
  }
  return weights;
}

uint8_t between(uint32_t low, uint32_t high, uint32_t weight, bool srgb) {
  const uint32_t a = low << 8 | (srgb ? 0x80 : low), b = high << 8 | (srgb ? 0x80 : high);
  return uint8_t((a * (64 - weight) + b * weight + 32) >> 6 >> 8);
}

Texels decodeSolid(BlockBits& bits) {
  Texels texels;
  for (uint8_t& channel : texels[0]) channel = uint8_t(bits.take(8));
  texels.fill(texels[0]);
  return texels;
}

Texels decodeBlock(const std::byte* block, bool srgb) {
  BlockBits bits(block);
  const uint32_t index = kModeOf[bits.peek() & 127];
  if (index == kModes) throw BrokenTexture("a block has a mode that does not exist");
  const Mode& mode = kMode[index];
  bits.take(mode.codeBits);
  if (index == kSolidMode) return decodeSolid(bits);
  bits.take(mode.hintBits);
  const uint32_t pattern = takePattern(mode, index == kOtherPairsMode, bits);
  const uint32_t ownPlane = mode.planes == 1 ? 4 : index == kAlphaPlaneMode ? 3 : bits.take(2);
  const std::array<uint8_t, 18> endpoints = takeEndpoints(mode, bits);
  const Weights weights = takeWeights(mode, pattern, bits);
  Texels texels;
  for (uint32_t texel = 0; texel < 16; ++texel) {
    const uint8_t* pairs = &endpoints[(pattern >> (2 * texel) & 3) * 2 * mode.components];
    for (uint32_t c = 0; c < 4; ++c) {
      const uint32_t component = mode.components == 2 ? c / 3 : c;
      const bool given = component < mode.components;
      texels[texel][c] = !given ? uint8_t{255}
                                : between(pairs[2 * component], pairs[2 * component + 1],
                                          weights.of[texel][c == ownPlane], srgb && c < 3);
    }
  }
  return texels;
}

}  // namespace

void decodeUastc(std::span<const std::byte> blocks, ImageSize size, bool srgb, std::byte* rgba) {
  const size_t across = (size.width + 3) / 4, down = (size.height + 3) / 4;
  if (blocks.size() != across * down * kUastcBlockBytes) throw BrokenTexture("a level has not the bytes of its size");
  parallelFor(down, std::max<size_t>(1, 4096 / across), [&](size_t begin, size_t end) {
    for (size_t i = begin * across; i < end * across; ++i) {
      const Texels texels = decodeBlock(&blocks[i * kUastcBlockBytes], srgb);
      const size_t x = i % across * 4, y = i / across * 4;
      const size_t width = std::min<size_t>(4, size.width - x), height = std::min<size_t>(4, size.height - y);
      for (size_t row = 0; row < height; ++row)
        std::copy_n(reinterpret_cast<const std::byte*>(&texels[row * 4]), width * 4,
                    rgba + ((y + row) * size.width + x) * 4);
    }
  });
}

}  // namespace latelight::scene
