// Converts scans of lidar sensors.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

namespace latelight::python {

LidarPattern patternOf(nanobind::handle pattern);  // of a latelight.lidar.Pattern
nanobind::dict pointsOf(LidarPoints&& points);     // the fields of a latelight.lidar.Scan
void bindLidar(nanobind::module_& module);

}  // namespace latelight::python
