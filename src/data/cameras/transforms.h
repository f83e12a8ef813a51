// Reads and writes transforms.json of nerfstudio and instant-ngp: intrinsics for all pictures or per picture, and
// camera-to-world poses in OpenGL's camera frame.
#pragma once

#include <nlohmann/json.hpp>
#include <span>

#include "data/cameras/calibrated.h"
#include "data/cameras/optics.h"

namespace latelight::data {

// Returns the reason that the format can't represent this lens, as the end of a sentence; empty if it can.
std::string missingInTransforms(const scene::Lens& lens);
// Describes a lens in the format: "camera_model", "w" and "h", and for models that have them the focal lengths, the
// principal point and the distortion.
nlohmann::ordered_json transformsLens(const scene::Lens& lens);

// `size` is the size of pictures for which the file states none. Throws Error(BadInput) that names the file and the
// frame if a frame is invalid or a scene::Lens can't represent its intrinsics.
std::vector<CalibratedCamera> readTransforms(const std::filesystem::path& file, PictureSize size = {});

// Writes cameras so that readTransforms() returns the same ones. Names are the pictures' paths. Throws Error(Usage) if
// a camera has no lens or one that missingInTransforms() rejects, and if the file cannot be written.
void writeTransforms(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras);

}  // namespace latelight::data
