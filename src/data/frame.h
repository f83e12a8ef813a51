// A finished frame of a data set: what every format is written from.
#pragma once

#include <cstdint>
#include <string>

#include "output/files.h"
#include "output/metadata.h"

namespace latelight::data {

struct DataFrame {
  uint64_t index = 0;  // in the job's order, over all its shards
  std::string name;    // stem of the frame's files, as in "000017"; unique in the data set
  output::FrameOutput picture;
  // Camera, frames of reference, settings, and what the ids stand for.
  output::Metadata metadata;
};

}  // namespace latelight::data
