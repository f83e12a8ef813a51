// The exposure of a job's camera, where it differs from the job's options.
#pragma once

#include <cstdint>
#include <optional>

#include "data/spec.h"

namespace latelight::data {

struct CameraExposure {
  std::optional<double> shutter, readout;  // seconds, in place of --shutter and --readout
  std::optional<uint64_t> noiseSeed;       // in place of the frame's index
  bool operator==(const CameraExposure&) const = default;
};

// Reads the keys "shutter", "readout" and "noiseSeed".
CameraExposure readExposure(Spec& spec);
// Returns `first` with the values of `others` in place of its empty ones.
CameraExposure combined(const CameraExposure& first, const CameraExposure& others);

}  // namespace latelight::data
