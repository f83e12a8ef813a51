// Masks as JSON: COCO's compressed run lengths, which pycocotools decodes.
#pragma once

#include <nlohmann/json.hpp>

#include "labels/mask.h"

namespace latelight::data {

inline nlohmann::ordered_json segmentationOf(const labels::Mask& mask) {
  return {{"size", {mask.height, mask.width}}, {"counts", mask.counts()}};
}

}  // namespace latelight::data
