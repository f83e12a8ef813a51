// The firings of spinning sensors and of rosettes. Directions use functions that round identically on every machine.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "lidar/sensor.h"
#include "scene/exact_math.h"

namespace latelight::lidar {

using exact::onCircle;
using glm::dvec2, glm::dvec3;

namespace {

// Returns the rank of each laser by its elevation.
std::vector<uint16_t> ringsOf(const std::vector<double>& elevations) {
  std::vector<uint16_t> order(elevations.size()), rings(elevations.size());
  std::iota(order.begin(), order.end(), uint16_t{0});
  std::ranges::stable_sort(order, {}, [&](uint16_t laser) { return elevations[laser]; });
  for (size_t rank = 0; rank < order.size(); ++rank) rings[order[rank]] = static_cast<uint16_t>(rank);
  return rings;
}

void checkSpinning(const Spinning& s) {
  if (s.elevations.empty() || s.elevations.size() > UINT16_MAX)
    badUsage("a spinning sensor has 1 to 65535 lasers, not {}", s.elevations.size());
  for (const auto* values : {&s.azimuths, &s.firing})
    if (!values->empty() && values->size() != s.elevations.size())
      badUsage("a spinning sensor of {} lasers needs as many azimuths and firing times, not {}", s.elevations.size(),
               values->size());
  if (!(s.cycle > 0) && s.columns == 0) badUsage("a spinning sensor needs a cycle above 0 or a number of columns");
}

void addFirings(const Spinning& s, const Sensor& sensor, double /*start*/, Pattern& pattern) {
  checkSpinning(s);
  const double cycle = s.cycle > 0 ? s.cycle : pattern.period / s.columns;
  const double columns = s.columns > 0 ? s.columns : std::floor(pattern.period / cycle + 1e-9);
  if (columns < 1) badUsage("a spinning sensor needs a cycle of at most the {} s of a scan", pattern.period);
  if (columns * double(s.elevations.size()) > double(kMaxFirings))
    badUsage("a scan has at most {} firings, not {}", kMaxFirings, columns * double(s.elevations.size()));
  const std::vector<uint16_t> rings = ringsOf(s.elevations);
  for (uint64_t column = 0; column < static_cast<uint64_t>(columns); ++column)
    for (size_t laser = 0; laser < s.elevations.size(); ++laser) {
      const double time = double(column) * cycle + (s.firing.empty() ? 0 : s.firing[laser]);
      const dvec2 azimuth = onCircle(sensor.rate * time + (s.azimuths.empty() ? 0 : s.azimuths[laser]) / 360);
      const dvec2 elevation = onCircle(s.elevations[laser] / 360);
      pattern.directions.emplace_back(elevation.x * azimuth.x, -elevation.x * azimuth.y, elevation.y);
      pattern.times.push_back(time);
      pattern.rings.push_back(rings[laser]);
    }
}

void addFirings(const Rosette& r, const Sensor& /*sensor*/, double start, Pattern& pattern) {
  if (!(r.cone > 0 && r.cone < 180) || !(r.pointRate > 0))
    badUsage("a rosette needs a cone between 0 and 180 degrees and a point rate above 0");
  if (!std::isfinite(start)) badUsage("start must be a finite number of seconds, not {}", start);
  const double points = std::max(1.0, std::round(pattern.period * r.pointRate));
  if (points > double(kMaxFirings)) badUsage("a scan has at most {} firings, not {}", kMaxFirings, points);
  const double deflection = r.cone / 4 * (exact::kPi / 180);  // of each prism
  for (uint64_t i = 0; i < static_cast<uint64_t>(points); ++i) {
    const double time = double(i) / r.pointRate;
    dvec2 across(0);  // to the left and up, in radians
    for (const double speed : r.speeds) across += deflection * onCircle(speed / 60 * (start + time));
    const double angle = glm::length(across);
    const double scale = angle > 0 ? exact::sine(angle) / angle : 1;
    pattern.directions.emplace_back(exact::cosine(angle), across.x * scale, across.y * scale);
    pattern.times.push_back(time);
  }
  pattern.rings.resize(pattern.times.size());
}

}  // namespace

void check(const Pattern& pattern) {
  const size_t count = pattern.times.size();
  if (pattern.directions.size() != count || pattern.rings.size() != count)
    badUsage("a pattern needs as many directions, times and rings, not {}, {} and {}", pattern.directions.size(), count,
             pattern.rings.size());
  if (count > kMaxFirings) badUsage("a scan has at most {} firings, not {}", kMaxFirings, count);
  for (const dvec3& direction : pattern.directions)
    if (!(std::abs(glm::length(direction) - 1) < 1e-6)) badUsage("the directions of a pattern must be unit vectors");
  for (const double time : pattern.times)
    if (!std::isfinite(time)) badUsage("the times of a pattern must be finite");
  const Properties& p = pattern.properties;
  for (const double value : {pattern.period, p.ratedRange, p.maxRange, p.echoSeparation})
    if (!(value > 0)) badUsage("period, rated range, maximum range and echo separation of a sensor must be above 0");
  for (const double value : {p.minRange, p.rangeNoise, p.rangeResolution, p.divergence[0], p.divergence[1]})
    if (!(value >= 0) || !std::isfinite(value))
      badUsage("minimum range, range noise, range resolution and divergence of a sensor must be at least 0");
}

Pattern patternOf(const Sensor& sensor, double start) {
  if (!(sensor.rate > 0) || !std::isfinite(sensor.rate))
    badUsage("a sensor's rate must be above 0 scans per second, not {}", sensor.rate);
  Pattern pattern{.name = sensor.name, .period = 1 / sensor.rate, .properties = sensor.properties};
  std::visit([&](const auto& scanner) { addFirings(scanner, sensor, start, pattern); }, sensor.scanner);
  check(pattern);
  return pattern;
}

}  // namespace latelight::lidar
