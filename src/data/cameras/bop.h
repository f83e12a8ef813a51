// Reads and writes scene_camera.json of BOP (Benchmark for 6D Object Pose Estimation): the intrinsic matrix K and the
// world-to-camera pose of each picture, in millimeters.
#pragma once

#include <span>

#include "data/cameras/calibrated.h"
#include "data/cameras/optics.h"

namespace latelight::data {

// Reads cameras in the order of the pictures' numbers, which are the cameras' names. `size` is the pictures' size,
// which the file does not state. Throws Error(BadInput) that names the file and the picture.
std::vector<CalibratedCamera> readBop(const std::filesystem::path& file, PictureSize size);

// Writes cameras so that readBop() returns the same ones. `depthScale` is the millimeters per unit of the depth
// pictures. Throws Error(Usage) if a camera lacks a pinhole lens or its name is not a whole number, and if the file
// cannot be written.
void writeBop(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras, double depthScale);

}  // namespace latelight::data
