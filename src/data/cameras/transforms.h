// transforms.json, as nerfstudio and instant-ngp read it: intrinsics for all pictures or for each, and poses in
// OpenGL's camera frame.
#pragma once

#include <span>

#include "data/cameras/calibrated.h"
#include "data/cameras/optics.h"

namespace latelight::data {

// `size`: of pictures whose size the file does not say. Throws Error(BadInput) that names the file and the frame for
// what is broken, or can't be said by a lens.
std::vector<CalibratedCamera> readTransforms(const std::filesystem::path& file, PictureSize size = {});

// The same cameras, read again. Each needs a lens other than a cube map's; throws Error(Usage) without, and where the
// file can't be written. Names are the pictures' paths.
void writeTransforms(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras);

}  // namespace latelight::data
