// The objects of a frame as JSON: boxes, masks, visible shares, occlusion and keypoints. The format "boxes" writes them
// for data sets, and `latelight render --labels` for single pictures.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "data/format.h"

namespace latelight::data {

struct ObjectLabels {
  bool whole = true;   // amodal masks and their extents, visible shares, occlusion
  bool masks = false;  // masks as run lengths
  std::vector<ObjectKeypoint> keypoints;

  std::vector<output::Aov> needs() const { return {output::Aov::Id}; }
  Extras needsExtras() const { return {.boxes = true, .alone = whole, .order = whole, .keypoints = keypoints}; }

  // `frame` has what needs() and needsExtras() require, and may have what other formats of a job require.
  nlohmann::ordered_json describe(const DataFrame& frame) const;
};

}  // namespace latelight::data
