// The table of sensors, by their makers' documents. Elevations are nominal: a real sensor has a calibration of its own.
// If a maker states no standard deviation of the range, it is half of the stated accuracy.
#include <fmt/ranges.h>

#include <cmath>

#include "base/error.h"
#include "lidar/sensor.h"
#include "scene/exact_math.h"

namespace latelight::lidar {

namespace {

constexpr double kDegree = exact::kPi / 180;

// Firing times of lasers that fire one after the other.
std::vector<double> oneByOne(size_t lasers, double seconds) {
  std::vector<double> times(lasers);
  for (size_t i = 0; i < lasers; ++i) times[i] = double(i) * seconds;
  return times;
}

// Pairs of lasers: a lower one, and one `above` degrees higher.
std::vector<double> interleaved(size_t pairs, double lowest, double step, double above) {
  std::vector<double> elevations;
  for (size_t i = 0; i < pairs; ++i) {
    const double low = lowest + step * double(i);
    elevations.insert(elevations.end(), {low, low + above});
  }
  return elevations;
}

// Velodyne, "VLP-16 User Manual", 63-9243 Rev. D: chapter 9 and the appendix on timing.
Sensor vlp16() {
  return {"VLP-16",
          10,
          Spinning{interleaved(8, -15, 2, 16), {}, oneByOne(16, 2.304e-6), 55.296e-6},
          {.minRange = 0.9,
           .maxRange = 131.07,
           .ratedRange = 100,
           .rangeNoise = 0.015,
           .rangeResolution = 0.002,
           .divergence = {0.18 * kDegree, 0.07 * kDegree}}};
}

// Velodyne, "HDL-32E User Manual", 63-9113: appendix on the firing sequence.
Sensor hdl32e() {
  return {"HDL-32E",
          10,
          Spinning{interleaved(16, -92.0 / 3, 4.0 / 3, 64.0 / 3), {}, oneByOne(32, 1.152e-6), 46.08e-6},
          {.minRange = 0.9,
           .maxRange = 131.07,
           .ratedRange = 100,
           .rangeNoise = 0.02,
           .rangeResolution = 0.002,
           .divergence = {0.16 * kDegree, 0.08 * kDegree}}};
}

// Velodyne, "HDL-64E S2 User Manual": two blocks of 32 lasers. The sensor of KITTI.
Sensor hdl64e() {
  std::vector<double> elevations;
  for (int i = 0; i < 32; ++i) elevations.push_back(2 - i / 3.0);
  for (int i = 0; i < 32; ++i) elevations.push_back(-8.83 - i * 0.5);
  return {"HDL-64E S2",
          10,
          Spinning{elevations, {}, oneByOne(64, 0.75e-6), 48e-6},
          {.minRange = 0.9,
           .maxRange = 131.07,
           .ratedRange = 120,
           .rangeNoise = 0.02,
           .rangeResolution = 0.002,
           .divergence = {2e-3, 2e-3}}};
}

// Ouster, "OS1 Datasheet", first generation. Its divergence is the full width at half of the maximum. Azimuths are the
// design values of the first generation in the Ouster SDK (beam_azimuth_angles), which also count to the right.
Sensor os1(const char* name, int lasers, double highest, double divergence) {
  Spinning scanner{.columns = 1024};
  constexpr double kAzimuths[] = {3.164, 1.055, -1.055, -3.164};
  for (int i = 0; i < lasers; ++i) {
    scanner.elevations.push_back(highest - 2 * highest * i / (lasers - 1));
    scanner.azimuths.push_back(kAzimuths[i % 4]);
  }
  const double full = divergence * kDegree * std::sqrt(2 / 0.69314718055994530942);
  return {
      name,
      10,
      std::move(scanner),
      {.minRange = 0.8, .ratedRange = 120, .rangeNoise = 0.015, .rangeResolution = 0.012, .divergence = {full, full}}};
}
Sensor os1With64() {
  return os1("OS1-64", 64, 16.6, 0.13);
}
Sensor os1With128() {
  return os1("OS1-128", 128, 22.5, 0.18);
}

// Livox, "Mid-40 User Manual"; the speeds of the prisms are from Brazeal, Wilkinson and Hochmair 2021.
Sensor mid40() {
  return {"Livox Mid-40",
          10,
          Rosette{38.4, {7294, -4664}, 1e5},
          {.minRange = 1,
           .ratedRange = 260,
           .rangeNoise = 0.02,
           .rangeResolution = 0.001,
           .divergence = {0.03 * kDegree, 0.28 * kDegree}}};
}

}  // namespace

std::span<const SensorInfo> sensors() {
  static constexpr SensorInfo kSensors[] = {
      {"vlp-16", "Velodyne VLP-16: 16 lasers from -15 to 15 degrees", vlp16},
      {"hdl-32e", "Velodyne HDL-32E: 32 lasers from -30.67 to 10.67 degrees", hdl32e},
      {"hdl-64e", "Velodyne HDL-64E S2: 64 lasers from -24.33 to 2 degrees", hdl64e},
      {"os1-64", "Ouster OS1-64: 64 lasers from -16.6 to 16.6 degrees", os1With64},
      {"os1-128", "Ouster OS1-128: 128 lasers from -22.5 to 22.5 degrees", os1With128},
      {"mid-40", "Livox Mid-40: a rosette in a cone of 38.4 degrees", mid40},
  };
  return kSensors;
}

Sensor sensorNamed(std::string_view name) {
  std::vector<std::string_view> names;
  for (const SensorInfo& info : sensors()) {
    if (info.name == name) return info.make();
    names.push_back(info.name);
  }
  badUsage("there is no sensor \"{}\"; there are: {}", name, fmt::join(names, ", "));
}

}  // namespace latelight::lidar
