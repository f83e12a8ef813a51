// Converts arguments to cameras.
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <string_view>
#include <vector>

namespace latelight::python {

// Accepts a Camera or a list of them.
std::vector<Camera> camerasOf(nanobind::handle value, std::string_view name);

}  // namespace latelight::python
