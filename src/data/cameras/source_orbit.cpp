// The camera source "orbit": a circle or spiral around a target, in equal steps of azimuth, elevation and distance.
#include <cmath>

#include "data/cameras/around.h"
#include "data/cameras/optics.h"
#include "data/cameras/target.h"
#include "scene/exact_math.h"

namespace latelight::data {

std::vector<Shot> shotsOnOrbit(Spec& spec, const CameraContext& context) {
  const Optics optics = readOptics(spec, context.size);
  const uint64_t count = spec.count("count", 1, kMaxCameras);
  context.claim(spec, count, count * kNumberedNameBytes);
  const std::vector<double> turn = spec.has("azimuth") ? spec.numbers("azimuth", 2, 2) : std::vector<double>{0, 360};
  const std::vector<double> climb = spec.has("elevation") && spec.at("elevation").is_array()
                                        ? spec.numbers("elevation", 2, 2, {-90, 90})
                                        : std::vector<double>(2, spec.number("elevation", {-90, 90}, 20.0));
  const Target target = readTarget(spec, context);
  const Interval distance = readDistance(spec, "distance", target, optics.halfAngle);
  // An orbit of whole turns ends one step before its start, so that the first camera is not repeated.
  const double turns = (turn[1] - turn[0]) / 360;
  const bool closed = turns != 0 && turns == std::floor(turns);
  const double steps = closed || count == 1 ? double(count) : double(count - 1);
  std::vector<Shot> shots;
  for (uint64_t i = 0; i < count; ++i) {
    const auto along = [&](double first, double last) { return first + (last - first) * double(i) / steps; };
    const double elevation = along(climb[0], climb[1]);
    const Around place = around(context.axes, along(turn[0], turn[1]) / 360, exact::sinQuarters(elevation / 90));
    shots.push_back({numberedName("orbit", i, count), place.pose(target.center, along(distance.low, distance.high)),
                     optics.camera, optics.width, optics.height});
  }
  makeSequence(shots);
  return shots;
}

}  // namespace latelight::data
