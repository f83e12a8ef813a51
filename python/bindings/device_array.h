// Outputs in device memory as Python objects.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <map>
#include <string>
#include <vector>

namespace latelight::python {

// Returns the arrays by name. `views` is the shape of their view axes: empty for a single camera, (V), or (N, C) for
// worlds.
nanobind::dict deviceArrays(std::map<std::string, DeviceArray>&& arrays, const std::vector<size_t>& views);

}  // namespace latelight::python
