#include "values.h"

#include <algorithm>
#include <cmath>

namespace latelight::python {

namespace {

nb::object numpy(const char* function) {
  return nb::module_::import_("numpy").attr(function);
}

std::string shapeText(const std::vector<int64_t>& shape) {
  std::string text;
  for (const int64_t length : shape) text += (text.empty() ? "" : ", ") + (length < 0 ? "N" : std::to_string(length));
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

std::vector<int64_t> shapeOf(const nb::object& array) {
  std::vector<int64_t> shape;
  for (const nb::handle length : nb::tuple(array.attr("shape"))) shape.push_back(nb::cast<int64_t>(length));
  return shape;
}

bool fits(const std::vector<int64_t>& shape, const std::vector<int64_t>& wanted) {
  if (shape.size() != wanted.size()) return false;
  for (size_t i = 0; i < shape.size(); ++i)
    if (wanted[i] >= 0 && shape[i] != wanted[i]) return false;
  return true;
}

const char* kindText(std::string_view kinds) {
  if (kinds.find('f') != kinds.npos) return "numbers";
  return kinds.find('i') != kinds.npos ? "whole numbers" : "uint8";
}

template <typename T>
void requireFinite(const T* values, size_t count, std::string_view name) {
  for (size_t i = 0; i < count; ++i)
    if (!std::isfinite(values[i])) badValue("{} must hold finite numbers, not {}", name, values[i]);
}

}  // namespace

std::string typeName(nb::handle value) {
  return Py_TYPE(value.ptr())->tp_name;
}

std::string shown(const nb::object& value) {
  return nb::cast<std::string>(nb::str(nb::handle(value)));
}

bool boolOf(nb::handle value, std::string_view name) {
  if (value.ptr() == Py_True) return true;
  if (value.ptr() == Py_False) return false;
  badType("{} must be True or False, not {}", name, typeName(value));
}

double numberOf(nb::handle value, std::string_view name) {
  double number = 0;
  if (PyUnicode_Check(value.ptr()) || PyBool_Check(value.ptr()) || !nb::try_cast<double>(value, number))
    badType("{} must be a number, not {}", name, typeName(value));
  return number;
}

float floatOf(nb::handle value, std::string_view name) {
  const double number = numberOf(value, name);
  const auto rounded = static_cast<float>(number);
  if (std::isfinite(number) && !std::isfinite(rounded)) badValue("{} is too large: {}", name, number);
  return rounded;
}

int64_t integerOf(nb::handle value, std::string_view name, int64_t least, int64_t most) {
  const nb::object index = nb::steal(PyNumber_Index(value.ptr()));
  if (!index.is_valid() || PyBool_Check(value.ptr())) {
    PyErr_Clear();
    badType("{} must be a whole number, not {}", name, typeName(value));
  }
  int64_t number = 0;
  if (!nb::try_cast<int64_t>(index, number) || number < least || number > most)
    badValue("{} must be a whole number from {} to {}, not {}", name, least, most, shown(index));
  return number;
}

std::string textOf(nb::handle value, std::string_view name) {
  std::string text;
  if (!nb::try_cast<std::string>(value, text)) {
    PyErr_Clear();  // of a text that is no valid Unicode
    badType("{} must be a text, not {}", name, typeName(value));
  }
  return text;
}

std::string pathOf(nb::handle value, std::string_view name) {
  const nb::object path = nb::steal(PyOS_FSPath(value.ptr()));
  if (!path.is_valid() || !PyUnicode_Check(path.ptr())) {
    PyErr_Clear();
    badType("{} must be a path, not {}", name, typeName(value));
  }
  return textOf(path, name);
}

std::vector<std::string> textsOf(nb::handle value, std::string_view name) {
  if (PyUnicode_Check(value.ptr())) return {textOf(value, name)};
  const nb::object items = nb::steal(PySequence_List(value.ptr()));
  if (!items.is_valid()) {
    PyErr_Clear();
    badType("{} must be a list of texts, not {}", name, typeName(value));
  }
  std::vector<std::string> texts;
  for (const nb::handle item : nb::list(items)) texts.push_back(textOf(item, name));
  return texts;
}

nb::object arrayOf(nb::handle value, std::string_view name, const char* dtype, std::string_view kinds,
                   const std::vector<int64_t>& shape) {
  nb::object array;
  try {
    array = numpy("asarray")(value);
  } catch (nb::python_error& error) {
    if (!error.matches(PyExc_Exception)) throw;
    badType("{} must be an array of shape {}, not {}", name, shapeText(shape), typeName(value));
  }
  const std::vector<int64_t> has = shapeOf(array);
  if (!fits(has, shape)) badValue("{} must be an array of shape {}, not {}", name, shapeText(shape), shapeText(has));
  const auto kind = shown(array.attr("dtype").attr("kind"));
  const bool none = std::find(has.begin(), has.end(), 0) != has.end();  // an empty list is one of floats
  if (!none && kinds.find(kind) == kinds.npos)
    badType("{} must be an array of {}, not {}", name, kindText(kinds), shown(array.attr("dtype")));
  return numpy("ascontiguousarray")(array, dtype);
}

size_t lengthOf(const nb::object& array, size_t axis) {
  return static_cast<size_t>(shapeOf(array)[axis]);
}

void checkFinite(const float* values, size_t count, std::string_view name) {
  requireFinite(values, count, name);
}
void checkFinite(const double* values, size_t count, std::string_view name) {
  requireFinite(values, count, name);
}

nb::object matrix(const std::array<double, 16>& values) {
  return owned(std::vector<double>(values.begin(), values.end()), {4, 4});
}

}  // namespace latelight::python
