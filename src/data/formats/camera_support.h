// Rejects cameras that a format cannot express.
#pragma once

#include <string_view>

#include "output/metadata.h"

namespace latelight::data {

// Throw Error(Usage) that names the format and the camera: for orthographic cameras, and for these and all cameras with
// a lens that bends rays.
void requirePerspective(std::string_view format, const output::CameraMetadata& camera);
void requirePinhole(std::string_view format, const output::CameraMetadata& camera);

}  // namespace latelight::data
