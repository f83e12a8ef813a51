// Shapes of objects as JSON, in the records of frames and in lists of models.
#pragma once

#include <nlohmann/json.hpp>

#include "labels/shape.h"

namespace latelight::data {

nlohmann::ordered_json describeShape(const labels::Shape& shape);
labels::Shape shapeIn(const nlohmann::ordered_json& json);  // throws nlohmann's exceptions

}  // namespace latelight::data
