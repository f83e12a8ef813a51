// A finished frame of a data set, the input of every format.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "data/objects.h"
#include "output/files.h"
#include "output/metadata.h"

namespace latelight::data {

// The data of a frame that formats may require in addition to its outputs (extras.h).
struct Extras {
  bool boxes = false;    // objects, with their boxes
  bool alone = false;    // objects, also with their amodal masks
  bool shapes = false;   // objects, also with their shapes
  uint32_t samples = 0;  // N: ids and materials at N x N samples per pixel; 0: none
};

struct DataFrame {
  uint64_t index = 0;  // in the job's order, over all its shards
  std::string name;    // stem of the frame's files, as in "000017"; unique in the data set
  output::FrameOutput picture;
  // Camera, coordinate frames, settings, and the nodes and primitives that the ids identify.
  output::Metadata metadata;
  uint32_t scene = 0;  // the scene's index in the job

  std::vector<Object> objects;  // sorted by id
  // Id and material of a picture N times as wide and high, an ordered grid of N x N samples per pixel.
  output::FrameOutput samples;
};

}  // namespace latelight::data
