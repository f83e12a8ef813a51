// Instance masks: the pixels of a picture that show one object, run-length encoded in column order as in COCO (Lin et
// al. 2014, "Microsoft COCO: Common Objects in Context").
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "output/aov.h"

namespace latelight::labels {

// A box in pixels, which may extend beyond the picture.
struct PixelBox {
  int64_t x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PixelBox&) const = default;
};

struct Mask {
  uint32_t width = 0, height = 0;
  // Lengths of runs of pixels, alternately outside and inside the mask, beginning with outside. Pixels are in column
  // order, each column from top to bottom.
  std::vector<uint32_t> runs;

  uint64_t area() const;
  PixelBox box() const;  // the bounding box of the mask; empty at 0, 0 if the mask is empty
  // One byte per pixel, rows from top to bottom: 255 inside, 0 outside.
  std::vector<uint8_t> pixels() const;
  // The runs as the compressed text that pycocotools writes.
  std::string counts() const;
};

// Returns the mask of each id in the picture except 0.
std::map<uint32_t, Mask> masksOf(const output::AovImage& ids);

}  // namespace latelight::labels
