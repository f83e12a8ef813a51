// A finished frame of a data set: what every format is written from.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "data/objects.h"
#include "output/files.h"
#include "output/metadata.h"

namespace latelight::data {

// What a frame has beside its outputs, for formats that need it (extras.h).
struct Extras {
  bool boxes = false;    // objects, with their boxes
  bool alone = false;    // and with the pixels that each covers alone
  bool shapes = false;   // and with their shapes
  uint32_t samples = 0;  // N: ids of N x N samples a pixel
};

struct DataFrame {
  uint64_t index = 0;  // in the job's order, over all its shards
  std::string name;    // stem of the frame's files, as in "000017"; unique in the data set
  output::FrameOutput picture;
  // Camera, frames of reference, settings, and what the ids stand for.
  output::Metadata metadata;
  uint32_t scene = 0;  // the scene's number in the job

  std::vector<Object> objects;  // sorted by id
  // Id and material of a picture N times as wide and high: N x N ordered samples a pixel.
  output::FrameOutput samples;
};

}  // namespace latelight::data
