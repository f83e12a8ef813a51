// Binds the casting of rays: methods of Renderer, and CastTicket.
#pragma once

#include <nanobind/nanobind.h>

#include "shared_renderer.h"

namespace latelight::python {

void bindCastTicket(nanobind::module_& module);
void defineRays(nanobind::class_<SharedRenderer>& type);
void defineWorldRays(nanobind::class_<SharedRenderer>& type);

}  // namespace latelight::python
