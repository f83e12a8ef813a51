// Outputs in device memory as Python objects.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <map>
#include <string>

namespace latelight::python {

// Returns the arrays by name. If `single`, they belong to one camera and have no view axis.
nanobind::dict deviceArrays(std::map<std::string, DeviceArray>&& arrays, bool single);

}  // namespace latelight::python
