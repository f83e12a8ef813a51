// transforms.json, as nerfstudio and instant-ngp read it: intrinsics for all pictures or for each, and poses in
// OpenGL's camera frame.
#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "data/cameras/calibrated.h"
#include "data/cameras/optics.h"

namespace latelight::data {

// Why the format can't say this lens, as the end of a sentence; empty: it can.
std::string transformsLack(const scene::Lens& lens);
// What it says of one: "camera_model", "w" and "h", and of those models that have them focal lengths, principal point
// and distortion.
nlohmann::ordered_json transformsLens(const scene::Lens& lens);

// `size`: of pictures whose size the file does not say. Throws Error(BadInput) that names the file and the frame for
// what is broken, or can't be said by a lens.
std::vector<CalibratedCamera> readTransforms(const std::filesystem::path& file, PictureSize size = {});

// The same cameras, read again. Each needs a lens other than a cube map's; throws Error(Usage) without, and where the
// file can't be written. Names are the pictures' paths.
void writeTransforms(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras);

}  // namespace latelight::data
