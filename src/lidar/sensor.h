// Lidar sensors: how they fire, and what limits their measurements. A sensor's frame has X forward, Y left and Z up
// (REP 103 of ROS).
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace latelight::lidar {

struct Properties {
  double minRange = 0;                                          // meters; nearer surfaces return nothing, and block
  double maxRange = std::numeric_limits<double>::infinity();    // meters; farther returns are discarded
  double ratedRange = std::numeric_limits<double>::infinity();  // meters, at 80 % reflectance and 90 % probability of
                                                                // detection; infinite: any signal is detected
  double rangeNoise = 0;                                        // meters, standard deviation
  double rangeResolution = 0;                                   // meters; ranges are multiples of it; 0: exact
  // Horizontal and vertical full angles of the beam in radians, at 1/e^2 of the irradiance in its center.
  std::array<double, 2> divergence{};
  double echoSeparation = 1;  // meters; nearer surfaces along a beam are one echo
};

// The firings of one scan.
struct Pattern {
  std::string name;
  std::vector<glm::dvec3> directions;  // unit vectors in the sensor's frame
  std::vector<double> times;           // seconds since the scan began, one per direction
  std::vector<uint16_t> rings;         // index of the laser, from the lowest elevation up
  double period = 0;                   // seconds from one scan to the next
  Properties properties{};
};

// Throws Error(Usage) if a pattern is not valid.
void check(const Pattern& pattern);

// Lasers that turn clockwise, seen from above. A scan begins forward.
struct Spinning {
  std::vector<double> elevations;  // degrees, by laser
  std::vector<double> azimuths{};  // degrees that each laser points to the right of the rotor; empty: 0
  std::vector<double> firing{};    // seconds from the beginning of a cycle to each laser's firing; empty: at once
  double cycle = 0;                // seconds from one firing of a laser to its next; 0: a column's share of the period
  uint32_t columns = 0;            // cycles per scan; 0: as many as fit
};

// A single beam that two equal prisms deflect, which turn at different speeds (Brazeal, Wilkinson and Hochmair 2021, "A
// Rigorous Observation Model for the Risley Prism-Based Livox Mid-40 Lidar Sensor"; here with thin prisms).
struct Rosette {
  double cone = 0;                 // degrees, full angle
  std::array<double, 2> speeds{};  // revolutions per minute
  double pointRate = 0;            // points per second
};

struct Sensor {
  std::string name;
  double rate = 0;  // scans per second
  std::variant<Spinning, Rosette> scanner;
  Properties properties{};
};

inline constexpr uint64_t kMaxFirings = 10'000'000;  // of a scan

// Returns the firings of the scan that begins `start` seconds after the sensor was switched on. Only rosettes depend on
// it. Throws Error(Usage) if the sensor is not valid.
Pattern patternOf(const Sensor& sensor, double start = 0);

// An entry of the table of sensors.
struct SensorInfo {
  std::string_view name, description;
  Sensor (*make)();
};
std::span<const SensorInfo> sensors();

// Throws Error(Usage) that lists the names if there is no such sensor.
Sensor sensorNamed(std::string_view name);

}  // namespace latelight::lidar
