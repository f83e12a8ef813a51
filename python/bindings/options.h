// The table of options (include/latelight/options.def) as keyword arguments: exposure=1.5, shadow_filter="pcss".
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <functional>
#include <string>

namespace latelight::python {

// "shadowFilter" as "shadow_filter".
std::string snakeCase(std::string_view member);

// Options that keyword arguments set. `cameras`: converts those of a list.
Options optionsOf(nanobind::handle size, nanobind::handle outputs, const nanobind::dict& keywords);

// What a signature says of them, and a docstring.
std::string optionParameters();
std::string optionDocs();
std::string outputDocs();

// The same error, with options named as keyword arguments.
Error inPython(const Error& error);

}  // namespace latelight::python
