#include "data/cameras/exposure.h"

namespace latelight::data {

CameraExposure readExposure(Spec& spec) {
  constexpr double kLongest = 1e4;                  // seconds, as for the options
  constexpr uint64_t kMaxSeed = uint64_t{1} << 53;  // doubles represent all integers up to it
  CameraExposure exposure;
  if (spec.has("shutter")) exposure.shutter = spec.number("shutter", {0, kLongest});
  if (spec.has("readout")) exposure.readout = spec.number("readout", {-kLongest, kLongest});
  if (spec.has("noiseSeed")) exposure.noiseSeed = spec.count("noiseSeed", 0, kMaxSeed);
  return exposure;
}

CameraExposure combined(const CameraExposure& first, const CameraExposure& others) {
  return {.shutter = first.shutter ? first.shutter : others.shutter,
          .readout = first.readout ? first.readout : others.readout,
          .noiseSeed = first.noiseSeed ? first.noiseSeed : others.noiseSeed};
}

}  // namespace latelight::data
