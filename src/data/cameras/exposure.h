// The exposure of a job's camera, where it differs from the job's options.
#pragma once

#include <cstdint>
#include <optional>

#include <nlohmann/json.hpp>
#include <string>

#include "data/spec.h"

namespace latelight::data {

struct CameraExposure {
  std::optional<double> shutter, readout;  // seconds, in place of --shutter and --readout
  std::optional<uint64_t> noiseSeed;       // in place of the frame's index
  std::optional<double> ev;                // stops, in place of --exposure
  bool operator==(const CameraExposure&) const = default;
};

// Reads the keys "shutter", "readout", "noiseSeed", "EV", "ISO" and "fNumber". The sensitivity S, the f-number N and
// the exposure time t of a camera add log2(t S / (100 N^2)) to the stops, as the exposure of UsdGeomCamera.
CameraExposure readExposure(Spec& spec);
// The same from an object of a camera file, which may have any other keys. Throws Error(BadInput) whose message begins
// with `where` if a value is invalid.
CameraExposure exposureIn(const nlohmann::ordered_json& object, const std::string& where);
// Writes the values that are not empty, under the same keys.
void writeExposure(nlohmann::ordered_json& object, const CameraExposure& exposure);
// Returns `first` with the values of `others` in place of its empty ones.
CameraExposure combined(const CameraExposure& first, const CameraExposure& others);

}  // namespace latelight::data
