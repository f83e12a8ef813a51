// Converts the arguments of render_worlds() and submit_worlds().
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <functional>
#include <string>

namespace latelight::python {

// Removes the arguments that describe worlds from `keywords`. `lightOf` returns a light of the scene.
Worlds worldsOf(nanobind::handle count, nanobind::handle cameras, nanobind::dict& keywords,
                const std::function<Light(Handle<Light>)>& lightOf);
std::string worldParameters();  // of a signature: ", instances: ... = None" and so on
std::string worldDocs();

}  // namespace latelight::python
