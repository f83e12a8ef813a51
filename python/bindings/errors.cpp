// Translates Latelight's errors to the Python classes of latelight/errors.py, by exit code.
#include "bindings.h"
#include "interpreter.h"
#include "values.h"

namespace latelight::python {

namespace {

const char* className(const Error& error) {
  if (dynamic_cast<const TypeMistake*>(&error)) return "ArgumentTypeError";
  switch (error.code()) {
    case ExitCode::Usage:
      return "UsageError";
    case ExitCode::BadInput:
      return "InputError";
    case ExitCode::NoDevice:
      return "NoDeviceError";
    case ExitCode::DeviceLost:
      return "DeviceLostError";
    case ExitCode::OutOfMemory:
      return "OutOfMemoryError";
    default:
      return "LatelightError";
  }
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    const RunningPython section;
    const nb::object type = nb::module_::import_("latelight.errors").attr(className(error));
    PyErr_SetString(type.ptr(), error.what());
  }
}

}  // namespace

void bindErrors() {
  nb::register_exception_translator(translate);
}

}  // namespace latelight::python
