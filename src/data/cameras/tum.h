// Trajectories in the format of TUM's RGB-D benchmark: a line "time tx ty tz qx qy qz qw" a pose, camera to world.
#pragma once

#include <span>

#include "data/cameras/calibrated.h"

namespace latelight::data {

// Names are the times as they are written. Throws Error(BadInput) that names the file and the line.
std::vector<CalibratedCamera> readTum(const std::filesystem::path& file);

// The same poses, read again; lenses are not in the format. Throws Error(Usage) where a name is no number, and where
// the file can't be written.
void writeTum(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras);

}  // namespace latelight::data
