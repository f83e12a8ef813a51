// The table of options (include/latelight/options.def) as keyword arguments: exposure=1.5, shadow_filter="pcss".
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <string>
#include <string_view>

namespace latelight::python {

// "shadowFilter" as "shadow_filter".
std::string snakeCase(std::string_view member);

// What render() is given: (width, height) or None, names of outputs, and options by keyword.
Options optionsOf(nanobind::handle size, nanobind::handle outputs, const nanobind::dict& keywords);

// What a signature says of them, and a docstring.
std::string optionParameters();
std::string optionDocs();
std::string outputDocs();

// The same error, with options named as keyword arguments.
Error inPython(const Error& error);

}  // namespace latelight::python
