// Reads the sensor of the format "lidar", and states its axes.
#pragma once

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include "lidar/sensor.h"

namespace latelight::data {

// Reads the name of a sensor, or an object with the name or the kind of scanner as "type" and the values that differ.
// Throws Error(Usage) that names the key.
lidar::Sensor readSensor(const nlohmann::ordered_json& value);

// Returns the transform to OpenCV's camera frame (X right, Y down, Z forward) from the frame of a sensor (X forward, Y
// left, Z up, as KITTI's Velodyne) that faces as the camera does, at its position.
glm::dmat4 cameraFromSensorAxes();

}  // namespace latelight::data
