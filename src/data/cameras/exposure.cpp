#include "data/cameras/exposure.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "data/cameras/json_file.h"
#include "render/options/options.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr uint64_t kMaxSeed = uint64_t{1} << 53;  // doubles represent all integers up to it

constexpr double kMaxEv = render::kMaxExposure;
constexpr Limits kStops{-kMaxEv, kMaxEv};
constexpr Limits kSettings{1e-3, 1e7};  // of ISO and f-numbers

// Returns the limits of the option whose value a camera's value replaces.
Limits limitsOf(const char* option) {
  const render::Range& range = render::rangeOf(option);
  return {range.least, range.most};
}

std::optional<double> numberBetween(const Json& object, const char* key, Limits limits, const std::string& where) {
  if (!object.contains(key)) return std::nullopt;
  const double value = numberIn(object, key, 0, where);
  if (value < limits.least || value > limits.most)
    badInput("{}: \"{}\" must be a number from {} to {}, not {}", where, key, limits.least, limits.most, value);
  return value;
}

// Returns the stops of a camera's settings. `ev` is added to those of the others, of which all or none are given.
template <typename Fail>
std::optional<double> stopsOf(std::optional<double> ev, std::optional<double> iso, std::optional<double> fNumber,
                              std::optional<double> shutter, const Fail& fail) {
  if (!iso && !fNumber) return ev;
  if (!iso || !fNumber || shutter.value_or(0) <= 0) fail("\"ISO\" and \"fNumber\" require each other and \"shutter\"");
  const double stops = ev.value_or(0) + std::log2(*shutter * *iso / (100 * *fNumber * *fNumber));
  if (!render::isValidExposure(stops))
    fail(fmt::format("the exposure must be from -{} to {} stops, not {}", kMaxEv, kMaxEv, stops));
  return stops;
}

}  // namespace

CameraExposure exposureIn(const Json& object, const std::string& where) {
  CameraExposure exposure;
  exposure.shutter = numberBetween(object, "shutter", limitsOf("--shutter"), where);
  exposure.readout = numberBetween(object, "readout", limitsOf("--readout"), where);
  if (const auto seed = numberBetween(object, "noiseSeed", {0, double(kMaxSeed)}, where)) {
    if (*seed != std::floor(*seed)) badInput("{}: \"noiseSeed\" must be a whole number, not {}", where, *seed);
    exposure.noiseSeed = static_cast<uint64_t>(*seed);
  }
  exposure.ev = stopsOf(numberBetween(object, "EV", kStops, where), numberBetween(object, "ISO", kSettings, where),
                        numberBetween(object, "fNumber", kSettings, where), exposure.shutter,
                        [&](const std::string& problem) { badInput("{}: {}", where, problem); });
  return exposure;
}

void writeExposure(Json& object, const CameraExposure& exposure) {
  if (exposure.shutter) object["shutter"] = *exposure.shutter;
  if (exposure.readout) object["readout"] = *exposure.readout;
  if (exposure.noiseSeed) object["noiseSeed"] = *exposure.noiseSeed;
  if (exposure.ev) object["EV"] = *exposure.ev;
}

CameraExposure readExposure(Spec& spec) {
  CameraExposure exposure;
  if (spec.has("shutter")) exposure.shutter = spec.number("shutter", limitsOf("--shutter"));
  if (spec.has("readout")) exposure.readout = spec.number("readout", limitsOf("--readout"));
  if (spec.has("noiseSeed")) exposure.noiseSeed = spec.count("noiseSeed", 0, kMaxSeed);
  const auto number = [&](const char* key, Limits limits) {
    return spec.has(key) ? std::optional(spec.number(key, limits)) : std::nullopt;
  };
  exposure.ev = stopsOf(number("EV", kStops), number("ISO", kSettings), number("fNumber", kSettings), exposure.shutter,
                        [&](const std::string& problem) { badUsage("{}: {}", spec.path(), problem); });
  return exposure;
}

CameraExposure combined(const CameraExposure& first, const CameraExposure& others) {
  return {.shutter = first.shutter ? first.shutter : others.shutter,
          .readout = first.readout ? first.readout : others.readout,
          .noiseSeed = first.noiseSeed ? first.noiseSeed : others.noiseSeed,
          .ev = first.ev ? first.ev : others.ev};
}

}  // namespace latelight::data
