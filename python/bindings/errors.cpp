// Translates Latelight's errors to the Python classes of latelight/errors.py, by exit code.
#include <new>

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

void raise(const char* className, const char* sentence) {
  const RunningPython section;
  const nb::object type = nb::module_::import_("latelight.errors").attr(className);
  PyErr_SetString(type.ptr(), sentence);
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    raise(className(error), error.what());
  } catch (const std::bad_alloc&) {
    raise("OutOfMemoryError", "The machine has no memory left; use a smaller image or scene.");
  }
}

}  // namespace

void bindErrors() {
  nb::register_exception_translator(translate);
}

}  // namespace latelight::python
