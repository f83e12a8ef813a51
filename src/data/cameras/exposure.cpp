#include "data/cameras/exposure.h"

#include <cmath>

#include "base/error.h"
#include "data/cameras/json_file.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr double kLongest = 1e4;                  // seconds, as for the options
constexpr uint64_t kMaxSeed = uint64_t{1} << 53;  // doubles represent all integers up to it

std::optional<double> numberBetween(const Json& object, const char* key, double least, double most,
                                    const std::string& where) {
  if (!object.contains(key)) return std::nullopt;
  const double value = numberIn(object, key, 0, where);
  if (value < least || value > most)
    badInput("{}: \"{}\" must be a number from {} to {}, not {}", where, key, least, most, value);
  return value;
}

}  // namespace

CameraExposure exposureIn(const Json& object, const std::string& where) {
  CameraExposure exposure;
  exposure.shutter = numberBetween(object, "shutter", 0, kLongest, where);
  exposure.readout = numberBetween(object, "readout", -kLongest, kLongest, where);
  if (const auto seed = numberBetween(object, "noiseSeed", 0, double(kMaxSeed), where)) {
    if (*seed != std::floor(*seed)) badInput("{}: \"noiseSeed\" must be a whole number, not {}", where, *seed);
    exposure.noiseSeed = static_cast<uint64_t>(*seed);
  }
  return exposure;
}

void writeExposure(Json& object, const CameraExposure& exposure) {
  if (exposure.shutter) object["shutter"] = *exposure.shutter;
  if (exposure.readout) object["readout"] = *exposure.readout;
  if (exposure.noiseSeed) object["noiseSeed"] = *exposure.noiseSeed;
}

CameraExposure readExposure(Spec& spec) {
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
