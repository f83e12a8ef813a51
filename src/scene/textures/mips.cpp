// Generates mip levels with a box filter. All arithmetic is in integers, so that every machine produces the same bytes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/parallel.h"
#include "scene/textures/texture.h"
#include "scene/vector_clones.h"

namespace latelight::scene {
namespace {

struct Level {
  const uint32_t* source;  // RGBA pixels
  uint32_t* target;
  ImageSize from, to;
  bool srgb;
};

// Conversion from sRGB (IEC 61966-2-1) to linear light in 16 bits, and back from its upper 14 bits. At black, one sRGB
// step is 20 of the former and 5 of the latter, so a flat color survives any number of levels unchanged (tested).
struct SrgbTables {
  std::array<uint16_t, 256> linear;
  std::array<uint8_t, 16384> coded;

  SrgbTables() {
    for (int i = 0; i < 256; ++i) {
      double c = i / 255.0;
      double l = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
      linear[size_t(i)] = uint16_t(std::lround(l * 65535.0));
    }
    for (int i = 0; i < 16384; ++i) {
      double l = (4 * i + 1.5) / 65535.0;
      double c = l <= 0.0031308 ? l * 12.92 : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
      coded[size_t(i)] = uint8_t(std::lround(std::min(c, 1.0) * 255.0));
    }
  }
};

const SrgbTables& srgbTables() {
  static const SrgbTables tables;
  return tables;
}

// Halves rows of even size: four pixels become one. Two channels are processed per register, spaced so that sums don't
// overlap.
LATELIGHT_VECTOR_CLONES
void halveRow(const uint32_t* above, const uint32_t* below, uint32_t* target, size_t count) {
  constexpr uint32_t kLanes = 0x00ff00ffu, kHalf = 0x00020002u;
  for (size_t i = 0; i < count; ++i) {
    uint32_t a = above[2 * i], b = above[2 * i + 1], c = below[2 * i], d = below[2 * i + 1];
    uint32_t low = (a & kLanes) + (b & kLanes) + (c & kLanes) + (d & kLanes) + kHalf;
    uint32_t high = ((a >> 8) & kLanes) + ((b >> 8) & kLanes) + ((c >> 8) & kLanes) + ((d >> 8) & kLanes) + kHalf;
    target[i] = ((low >> 2) & kLanes) | (((high >> 2) & kLanes) << 8);
  }
}

void halveRowSrgb(const uint32_t* aboveRow, const uint32_t* belowRow, uint32_t* targetRow, size_t count) {
  const SrgbTables& tables = srgbTables();
  const uint16_t* linear = tables.linear.data();
  const uint8_t* coded = tables.coded.data();
  auto above = reinterpret_cast<const uint8_t*>(aboveRow), below = reinterpret_cast<const uint8_t*>(belowRow);
  auto target = reinterpret_cast<uint8_t*>(targetRow);
  for (size_t i = 0; i < count; ++i, above += 8, below += 8, target += 4) {
    for (int c = 0; c < 3; ++c) {
      uint32_t sum = uint32_t(linear[above[c]]) + linear[above[c + 4]] + linear[below[c]] + linear[below[c + 4]];
      target[c] = coded[sum >> 4];
    }
    target[3] = uint8_t((above[3] + above[7] + below[3] + below[7] + 2u) >> 2);
  }
}

// The source pixels that target pixel `i` covers along one axis, and their weights in units of 1 / total. For an odd
// size n, a target pixel covers n / ((n - 1) / 2) pixels: more than two and at most three, with weights that change
// along the row (Guthe and Heckbert, "Non-power-of-two mipmap creation", NVIDIA 2005).
struct Taps {
  uint32_t first;
  uint32_t count;
  uint32_t weight[3];
};

Taps tapsOf(uint32_t i, uint32_t from, uint32_t to) {
  if (from == 1) return {0, 1, {1, 0, 0}};
  if (from % 2 == 0) return {2 * i, 2, {1, 1, 0}};
  return {2 * i, 3, {to - i, to, i + 1}};
}

uint64_t totalWeight(uint32_t from) {
  return from == 1 ? 1 : (from % 2 == 0 ? 2 : from);
}

void shrinkRowExactly(const Level& level, uint32_t row) {
  const SrgbTables& tables = srgbTables();
  Taps down = tapsOf(row, level.from.height, level.to.height);
  uint64_t total = totalWeight(level.from.width) * totalWeight(level.from.height);
  for (uint32_t x = 0; x < level.to.width; ++x) {
    Taps across = tapsOf(x, level.from.width, level.to.width);
    uint64_t sum[4] = {};
    for (uint32_t j = 0; j < down.count; ++j) {
      auto source = reinterpret_cast<const uint8_t*>(level.source + size_t(down.first + j) * level.from.width);
      for (uint32_t i = 0; i < across.count; ++i) {
        const uint8_t* p = source + 4 * size_t(across.first + i);
        uint64_t weight = uint64_t(down.weight[j]) * across.weight[i];
        for (int c = 0; c < 4; ++c) sum[c] += weight * (level.srgb && c < 3 ? tables.linear[p[c]] : p[c]);
      }
    }
    uint8_t pixel[4];
    for (int c = 0; c < 4; ++c) {
      uint64_t mean = (sum[c] + total / 2) / total;
      pixel[c] = level.srgb && c < 3 ? tables.coded[mean >> 2] : uint8_t(mean);
    }
    std::memcpy(level.target + size_t(row) * level.to.width + x, pixel, 4);
  }
}

void shrinkRow(const Level& level, uint32_t row) {
  if (level.from.width % 2 != 0 || level.from.height % 2 != 0) return shrinkRowExactly(level, row);
  const uint32_t* above = level.source + size_t(2 * row) * level.from.width;
  auto halve = level.srgb ? halveRowSrgb : halveRow;
  halve(above, above + level.from.width, level.target + size_t(row) * level.to.width, level.to.width);
}

}  // namespace

void buildMips(Texture& texture) {
  auto* source = reinterpret_cast<uint32_t*>(texture.pixels.get());
  ImageSize from{texture.width, texture.height};
  for (uint32_t i = 1; i < texture.levels; ++i) {
    ImageSize to{std::max(1u, from.width / 2), std::max(1u, from.height / 2)};
    Level level{source, source + size_t(from.width) * from.height, from, to, texture.srgb};
    size_t rowsPerChunk = std::max<size_t>(1, 65536 / to.width);
    parallelFor(to.height, rowsPerChunk, [&](size_t begin, size_t end) {
      for (size_t row = begin; row < end; ++row) shrinkRow(level, uint32_t(row));
    });
    source = level.target;
    from = to;
  }
}

}  // namespace latelight::scene
