// Reads and writes trajectories in the format of the TUM RGB-D benchmark: one line "time tx ty tz qx qy qz qw" per
// camera-to-world pose.
#pragma once

#include <span>

#include "data/cameras/calibrated.h"

namespace latelight::data {

// Cameras are named by their times, as written in the file. Throws Error(BadInput) that names the file and the line.
std::vector<CalibratedCamera> readTum(const std::filesystem::path& file);

// Writes poses so that readTum() returns the same ones. The format has no lenses. Throws Error(Usage) if a name is not
// a number, and if the file cannot be written.
void writeTum(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras);

}  // namespace latelight::data
