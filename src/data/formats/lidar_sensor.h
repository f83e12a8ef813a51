// Reads the sensor of the format "lidar".
#pragma once

#include <nlohmann/json.hpp>

#include "lidar/sensor.h"

namespace latelight::data {

// Reads the name of a sensor, or an object with the name or the kind of scanner as "type" and the values that differ.
// Throws Error(Usage) that names the key.
lidar::Sensor readSensor(const nlohmann::ordered_json& value);

}  // namespace latelight::data
