// Converts the arguments of render_worlds() and submit_worlds().
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <functional>
#include <string>

namespace latelight::python {

// Return the values of the scene's elements.
struct SceneValues {
  std::function<Instance(Handle<Instance>)> instance;
  std::function<Material(Handle<Material>)> material;
  std::function<Light(Handle<Light>)> light;
};

// Removes the arguments that describe worlds from `keywords`.
Worlds worldsOf(nanobind::handle count, nanobind::handle cameras, nanobind::dict& keywords, const SceneValues& scene);
std::string worldParameters();  // of a signature: ", instances: ... = None" and so on
std::string worldDocs();

}  // namespace latelight::python
