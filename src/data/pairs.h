// Pairs of frames of a data set, for correspondence: the second image of a pair is described relative to the first.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "labels/correspondence.h"

namespace latelight::data {

struct PairTarget {
  enum class Kind {
    Step,    // the frame `step` poses further in the sequence; 1: the next frame, -1: the previous one
    Camera,  // the frame of the camera with this name, at its own time
    Member,  // the frame of the rig's member with this name, with the same pose of the rig
  };
  Kind kind = Kind::Step;
  int64_t step = 1;
  std::string name{};
  bool operator==(const PairTarget&) const = default;
};

// A frame's pair that exists.
struct FramePair {
  PairTarget target;
  std::string second;          // name of the second image's frame; empty: the set does not contain it
  std::optional<double> time;  // scene time of the second image; empty: the scene is at rest
  labels::Correspondence match;
};

}  // namespace latelight::data
