#include "data/formats/lidar_sensor.h"

#include <cmath>

#include "base/error.h"
#include "data/spec.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr double kRadians = M_PI / 180;
constexpr size_t kMaxLasers = 4096;

// "elevations": degrees by laser, or with "rings", the lowest and the highest.
std::vector<double> readElevations(Spec& spec) {
  constexpr Limits kElevation{-90, 90};
  if (!spec.has("rings")) return spec.numbers("elevations", 1, kMaxLasers, kElevation);
  const uint64_t rings = spec.count("rings", 1, kMaxLasers);
  const std::vector<double> ends = spec.numbers("elevations", 2, 2, kElevation);
  std::vector<double> elevations;
  for (uint64_t i = 0; i < rings; ++i)
    elevations.push_back(rings == 1 ? ends[0] : ends[0] + (ends[1] - ends[0]) * (double(i) / double(rings - 1)));
  return elevations;
}

// One value per laser: a list, or a single number from which `make` derives them.
template <typename Make>
std::vector<double> readPerLaser(Spec& spec, std::string_view key, size_t lasers, Limits limits, const Make& make) {
  if (!spec.at(key).is_number()) return spec.numbers(key, lasers, lasers, limits);
  const double value = spec.number(key, limits);
  std::vector<double> values;
  for (size_t i = 0; i < lasers; ++i) values.push_back(make(value, i));
  return values;
}

// The step of the rotor: "azimuth-step" in degrees, "columns" per scan, or "cycle" in seconds.
void readSteps(Spec& spec, double rate, lidar::Spinning& scanner, bool isNew) {
  const int given = int(spec.has("azimuth-step")) + int(spec.has("columns")) + int(spec.has("cycle"));
  if (given > 1 || (isNew && given == 0))
    badUsage("{} needs one of \"azimuth-step\", \"columns\" and \"cycle\"", spec.path());
  if (given == 0) return;
  scanner.columns = 0;
  scanner.cycle = 0;
  if (spec.has("columns")) scanner.columns = static_cast<uint32_t>(spec.count("columns", 1, 1'000'000));
  if (spec.has("cycle")) scanner.cycle = spec.number("cycle", {1e-9, 1e3});
  if (spec.has("azimuth-step")) scanner.cycle = spec.number("azimuth-step", {1e-4, 360}) / 360 / rate;
}

void readScanner(Spec& spec, double rate, lidar::Spinning& scanner, bool isNew) {
  if (isNew || spec.has("elevations")) {
    scanner.elevations = readElevations(spec);
    scanner.azimuths.clear();
    scanner.firing.clear();
  }
  const size_t lasers = scanner.elevations.size();
  if (spec.has("azimuths"))
    scanner.azimuths = readPerLaser(spec, "azimuths", lasers, {-360, 360}, [](double all, size_t) { return all; });
  if (spec.has("firing"))
    scanner.firing =
        readPerLaser(spec, "firing", lasers, {0, 1e3}, [](double step, size_t i) { return step * double(i); });
  readSteps(spec, rate, scanner, isNew);
}

void readScanner(Spec& spec, double /*rate*/, lidar::Rosette& scanner, bool isNew) {
  if (isNew || spec.has("cone")) scanner.cone = spec.number("cone", {1e-3, 179});
  if (isNew || spec.has("point-rate")) scanner.pointRate = spec.number("point-rate", {1e-3, 1e9});
  if (!isNew && !spec.has("speeds")) return;
  const std::vector<double> speeds = spec.numbers("speeds", 2, 2, {-1e6, 1e6});
  scanner.speeds = {speeds[0], speeds[1]};
}

void readProperties(Spec& spec, lidar::Properties& p) {
  p.minRange = spec.number("min-range", kNotNegative, p.minRange);
  p.rangeNoise = spec.number("range-noise", kNotNegative, p.rangeNoise);
  p.rangeResolution = spec.number("range-resolution", kNotNegative, p.rangeResolution);
  p.echoSeparation = spec.number("echo-separation", kPositive, p.echoSeparation);
  if (spec.has("max-range")) p.maxRange = spec.number("max-range", kPositive);
  if (spec.has("rated-range")) {
    const bool unlimited = spec.at("rated-range").is_null();
    p.ratedRange = unlimited ? std::numeric_limits<double>::infinity() : spec.number("rated-range", kPositive);
  }
  if (!spec.has("divergence")) return;
  const std::vector<double> degrees = spec.numbers("divergence", 2, 2, {0, 90});
  p.divergence = {degrees[0] * kRadians, degrees[1] * kRadians};
}

}  // namespace

glm::dmat4 cameraFromSensorAxes() {
  return glm::dmat4(glm::dvec4(0, 0, 1, 0), glm::dvec4(-1, 0, 0, 0), glm::dvec4(0, -1, 0, 0), glm::dvec4(0, 0, 0, 1));
}

lidar::Sensor readSensor(const Json& value) {
  if (value.is_string()) return lidar::sensorNamed(value.get<std::string>());
  if (!value.is_object()) badUsage("sensor takes the name of a sensor, or an object with its \"type\"");
  Spec spec(value, "sensor");
  const std::string type = spec.text("type");
  const bool spins = type == "spinning", isNew = spins || type == "rosette";
  lidar::Sensor sensor;
  if (isNew)
    sensor.name = type;
  else
    sensor = lidar::sensorNamed(type);
  if (isNew && !spins) sensor.scanner = lidar::Rosette{};
  sensor.name = spec.text("name", sensor.name);
  sensor.rate = spec.number("rate", {1e-3, 1e5}, isNew ? std::nullopt : std::optional(sensor.rate));
  std::visit([&](auto& scanner) { readScanner(spec, sensor.rate, scanner, isNew); }, sensor.scanner);
  readProperties(spec, sensor.properties);
  spec.finish();
  lidar::patternOf(sensor);  // throws if the values do not fit together
  return sensor;
}

}  // namespace latelight::data
