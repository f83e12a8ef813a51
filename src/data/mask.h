// Which pixels of a picture show something, as COCO has it: runs down the columns.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "output/aov.h"

namespace latelight::data {

// Pixels, which may lie beyond the picture.
struct PixelBox {
  int64_t x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PixelBox&) const = default;
};

struct Mask {
  uint32_t width = 0, height = 0;
  // Lengths of runs of pixels, the first column from the top, then the next: outside, inside, outside, ...
  std::vector<uint32_t> runs;

  uint64_t area() const;
  PixelBox box() const;  // around what is inside; empty at 0, 0 where nothing is
  // A byte a pixel, rows from the top: 255 inside, 0 outside.
  std::vector<uint8_t> pixels() const;
  // The runs as text, as pycocotools writes them.
  std::string counts() const;
};

// Of all ids in a picture but 0.
std::map<uint32_t, Mask> masksOf(const output::AovImage& ids);

}  // namespace latelight::data
