// The table of options (include/latelight/options.def) as keyword arguments: exposure=1.5, shadow_filter="pcss".
#pragma once

#include <latelight/latelight.h>
#include <nanobind/nanobind.h>

#include <string>
#include <string_view>
#include <vector>

#include "values.h"

namespace latelight::python {

// Returns "shadow_filter" for "shadowFilter".
std::string snakeCase(std::string_view member);

// Converts the arguments of render(): size is (width, height) or None, outputs are names, and options are keywords.
Options optionsOf(nanobind::handle size, nanobind::handle outputs, const nanobind::dict& keywords);

// Throws TypeMistake for keywords that are neither options nor arguments that describe worlds, and the errors of
// optionsOf() for the values of options.
void checkWorldKeywords(const nanobind::dict& keywords);

// The parts of signatures and docstrings that describe options and outputs.
std::string optionParameters(const std::vector<std::string>& except = {});
std::string optionDocs();
std::string outputDocs();

// Returns the same error with options named as keyword arguments.
Error withKeywords(const Error& error);

// Calls `work`, whose errors then name options as keyword arguments.
template <typename Work>
auto inPython(Work work) {
  try {
    return work();
  } catch (const TypeMistake&) {  // names Python's arguments already, and is also a Python TypeError
    throw;
  } catch (const Error& error) {
    throw withKeywords(error);
  }
}

}  // namespace latelight::python
