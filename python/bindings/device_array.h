// Outputs in device memory as Python has them.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <map>
#include <string>

namespace latelight::python {

// By name. `single`: of one camera, without the axis of the views.
nanobind::dict deviceArrays(std::map<std::string, DeviceArray>&& arrays, bool single);

}  // namespace latelight::python
