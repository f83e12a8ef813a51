// scene_camera.json of BOP's data sets: K and the pose of each picture, world to camera, in millimetres.
#pragma once

#include <span>

#include "data/cameras/calibrated.h"
#include "data/cameras/optics.h"

namespace latelight::data {

// Names are the pictures' numbers, in their order; `size` is that of the pictures, which the file does not say. Throws
// Error(BadInput) that names the file and the picture.
std::vector<CalibratedCamera> readBop(const std::filesystem::path& file, PictureSize size);

// The same cameras, read again. `depthScale`: millimetres of a unit of the depth pictures. Each needs a pinhole lens
// and a whole number for a name; throws Error(Usage) without, and where the file can't be written.
void writeBop(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras, double depthScale);

}  // namespace latelight::data
