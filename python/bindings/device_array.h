// Outputs in device memory as Python objects.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <map>
#include <string>
#include <vector>

namespace latelight::python {

enum class Axes { Images, Rays };  // after those of the views: rows and columns, or none

// Returns the arrays by name. `views` is the shape of their view axes: empty for a single camera, (V), or (N, C) for
// worlds.
nanobind::dict deviceArrays(std::map<std::string, DeviceArray>&& arrays, const std::vector<size_t>& views,
                            Axes axes = Axes::Images);
// Returns copies of images as NumPy's arrays.
nanobind::dict hostArrays(const std::map<std::string, DeviceArray>& arrays, const std::vector<size_t>& views);
bool isDeviceArray(nanobind::handle value);
// The arrays of `out`: None, or what a call with on_device returned.
std::map<std::string, DeviceArray> targetsOf(nanobind::handle value);

}  // namespace latelight::python
