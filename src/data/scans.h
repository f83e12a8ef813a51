// Lidar scans of the frames of a data set.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lidar/scan.h"

namespace latelight::data {

// A scan that a format requires per frame. Formats with equal keys share it.
struct ScanRequest {
  std::string key;           // the options that it depends on
  uint64_t noiseStream = 0;  // sensors with different streams have independent noise
  lidar::Sensor sensor;
  double seconds = 0;              // until the last firing of a scan, and at least its period
  lidar::ScanOptions options{};    // without the seed, which each frame has of its own
  glm::dmat4 cameraFromSensor{1};  // OpenCV's camera frame from the sensor's
};
using ScanRequests = std::vector<std::shared_ptr<const ScanRequest>>;

struct FrameScan {
  std::shared_ptr<const ScanRequest> request;
  std::optional<double> start;    // scene time at which the scan begins; empty: the scene is at rest
  glm::dmat4 worldFromSensor{1};  // at that time, in the frame of the option `axes`
  lidar::Points points;
};

}  // namespace latelight::data
