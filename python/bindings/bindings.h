// The parts of the module latelight._core, with one file each.
#pragma once

#include <nanobind/nanobind.h>

namespace latelight::python {

void bindErrors();
void bindCamera(nanobind::module_& module);
void bindElements(nanobind::module_& module);
void bindScene(nanobind::module_& module);
void bindDeviceArray(nanobind::module_& module);
void bindRenderer(nanobind::module_& module);
void finishRenderers();  // waits for the devices of all renderers in this process

}  // namespace latelight::python
