#include "values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "interpreter.h"

namespace latelight::python {

namespace {

nb::object numpy(const char* name) {
  return nb::module_::import_("numpy").attr(name);
}

// Returns true for an instance of NumPy's class or of a derived class, without running code of the value.
bool isNumPy(nb::handle value, const nb::object& type) {
  return PyType_IsSubtype(Py_TYPE(value.ptr()), reinterpret_cast<PyTypeObject*>(type.ptr())) != 0;
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

char kindOf(const nb::object& array) {
  return shown(array.attr("dtype").attr("kind"))[0];
}

int64_t itemBytes(const nb::object& array) {
  return nb::cast<int64_t>(array.attr("dtype").attr("itemsize"));
}

// Returns "uint8", also for the other byte order.
std::string dtypeName(const nb::object& array) {
  return shown(array.attr("dtype").attr("name"));
}

struct ElementInfo {
  const char* kinds;
  const char* name;  // "an array of ..."
};
ElementInfo infoOf(Elements elements) {
  switch (elements) {
    case Elements::Floats:
      return {"f", "floats"};
    case Elements::Integers:
      return {"iu", "whole numbers"};
    case Elements::Uint8:
      return {"u", "uint8"};
    default:
      return {"fiu", "numbers"};
  }
}

bool has(const nb::object& array, Elements elements) {
  if (elements == Elements::Uint8) return dtypeName(array) == "uint8";
  return std::string_view(infoOf(elements).kinds).find(kindOf(array)) != std::string_view::npos;
}

// Returns true for an object with DLPack and none of NumPy's protocols. numpy.asarray() would wrap the object itself.
bool hasOnlyDlpack(nb::handle value) {
  if (!nb::hasattr(value, "__dlpack__")) return false;
  for (const char* protocol : {"__array__", "__array_interface__", "__array_struct__"})
    if (nb::hasattr(value, protocol)) return false;
  return true;
}

// Returns true if Python or NumPy rejected the value. Exceptions from Python code have a traceback when they reach C++,
// and errors such as MemoryError do not mean that the value has the wrong type.
bool isRefusal(const nb::python_error& error) {
  if (error.traceback().is_valid()) return false;
  for (PyObject* const type : {PyExc_TypeError, PyExc_ValueError, PyExc_OverflowError, PyExc_BufferError})
    if (error.matches(type)) return true;
  return false;
}

// Must follow a call that set Python's error indicator. Throws every error except a rejection.
void clearError() {
  const nb::python_error error;
  if (!isRefusal(error)) throw error;
}

// Stops at a nesting depth beyond that of NumPy's arrays, because NumPy rejects such lists.
void rejectMasks(nb::handle value, std::string_view name, const nb::object& maskedArray, int depth = 0) {
  constexpr int kMaxDepth = 64;
  if (isNumPy(value, maskedArray) && nb::cast<bool>(numpy("ma").attr("is_masked")(value)))
    badValue("{} has masked values: fill them first, with numpy.ma.filled()", name);
  if (depth == kMaxDepth || !(PyList_CheckExact(value.ptr()) || PyTuple_CheckExact(value.ptr()))) return;
  for (const nb::handle item : value) rejectMasks(item, name, maskedArray, depth + 1);
}
void rejectMasks(nb::handle value, std::string_view name) {
  rejectMasks(value, name, numpy("ma").attr("MaskedArray"));
}

template <typename T>
std::vector<T> valuesOf(const nb::object& array) {
  const auto view = viewOf<T>(array);
  return std::vector<T>(view.data(), view.data() + view.size());
}

// Decodes integers as glTF 2.0 and KHR_mesh_quantization define.
template <typename T>
void appendNormalized(const nb::object& array, const char* dtype, std::vector<float>& to) {
  constexpr auto kMax = static_cast<float>(std::numeric_limits<T>::max());
  for (const T value : valuesOf<T>(numpy("ascontiguousarray")(array, dtype)))
    to.push_back(std::max(static_cast<float>(value) / kMax, -1.0f));
}

// Returns false if the array has none of those types.
bool normalize(const nb::object& array, Integers integers, std::vector<float>& to) {
  const std::string dtype = dtypeName(array);
  if (integers == Integers::Normalized && dtype == "uint8") return appendNormalized<uint8_t>(array, "uint8", to), true;
  if (integers == Integers::Normalized && dtype == "uint16")
    return appendNormalized<uint16_t>(array, "uint16", to), true;
  if (integers == Integers::SignedNormalized && dtype == "int8")
    return appendNormalized<int8_t>(array, "int8", to), true;
  if (integers == Integers::SignedNormalized && dtype == "int16")
    return appendNormalized<int16_t>(array, "int16", to), true;
  return false;
}

// Rejects other small integers, whose meaning is unknown: such types usually store scaled values to save memory.
void rejectOtherSmallIntegers(const nb::object& array, Integers integers, std::string_view name) {
  if (integers == Integers::Plain || kindOf(array) == 'f' || itemBytes(array) > 2) return;
  badType("{} must be an array of floats, {}, not {}", name,
          integers == Integers::Normalized ? "uint8 or uint16" : "int8 or int16", dtypeName(array));
}

template <typename T>
void requireFinite(const std::vector<T>& values, std::string_view name) {
  for (const T value : values)
    if (!std::isfinite(value)) badValue("{} must hold finite numbers, not {}", name, value);
}

}  // namespace

std::string shapeText(const std::vector<int64_t>& shape) {
  std::string text;
  const char* any = "N";
  for (const int64_t length : shape) {
    text += text.empty() ? "" : ", ";
    if (length == kAnyLength)
      text += std::exchange(any, "M");
    else if (length < 0)
      text += length == kHeightLength ? "H" : length == kWidthLength ? "W" : length == kRowLength ? "3 or 4" : "C";
    else
      text += std::to_string(length);
  }
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

// With the module for types of C that are not built in ("numpy.ndarray"), and without it for classes.
std::string typeName(nb::handle value) {
  const nb::handle type = value.type();
  const auto name = nb::cast<std::string>(type.attr("__name__"));
  if (PyType_GetFlags(reinterpret_cast<PyTypeObject*>(type.ptr())) & Py_TPFLAGS_HEAPTYPE) return name;
  const auto module = nb::cast<std::string>(type.attr("__module__"));
  return module == "builtins" ? name : module + "." + name;
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
  if (PyFloat_CheckExact(value.ptr())) return PyFloat_AsDouble(value.ptr());
  const RunningPython section;
  rejectMasks(value, name);
  const bool isArray = isNumPy(value, numpy("generic")) || isNumPy(value, numpy("ndarray"));
  if (PyUnicode_Check(value.ptr()) || PyBool_Check(value.ptr()) ||
      (isArray && (nb::cast<int>(value.attr("ndim")) > 0 || !has(nb::borrow(value), Elements::Numbers))))
    badType("{} must be a number, not {}", name, typeName(value));
  const double number = PyFloat_AsDouble(value.ptr());
  if (number != -1 || !PyErr_Occurred()) return number;
  clearError();
  if (PyIndex_Check(value.ptr())) badValue("{} is too large", name);
  badType("{} must be a number, not {}", name, typeName(value));
}

float floatOf(nb::handle value, std::string_view name) {
  const double number = numberOf(value, name);
  const auto rounded = static_cast<float>(number);
  if (std::isfinite(number) && !std::isfinite(rounded)) badValue("{} is too large: {}", name, number);
  return rounded;
}

int64_t integerOf(nb::handle value, std::string_view name, int64_t least, int64_t most) {
  const RunningPython section;
  if (!PyLong_CheckExact(value.ptr())) rejectMasks(value, name);
  const nb::object index = nb::steal(PyNumber_Index(value.ptr()));
  if (!index.is_valid()) clearError();
  if (!index.is_valid() || PyBool_Check(value.ptr()))
    badType("{} must be a whole number, not {}", name, typeName(value));
  int64_t number = 0;
  if (!nb::try_cast<int64_t>(index, number) || number < least || number > most)
    badValue("{} must be a whole number from {} to {}, not {}", name, least, most, shown(index));
  return number;
}

std::string textOf(nb::handle value, std::string_view name) {
  if (!PyUnicode_Check(value.ptr())) badType("{} must be a text, not {}", name, typeName(value));
  Py_ssize_t bytes = 0;
  const char* text = PyUnicode_AsUTF8AndSize(value.ptr(), &bytes);
  if (text) return {text, static_cast<size_t>(bytes)};
  clearError();
  badValue("{} must be valid Unicode, without surrogates", name);
}

std::string pathOf(nb::handle value, std::string_view name) {
  const RunningPython section;
  const nb::object path = nb::steal(PyOS_FSPath(value.ptr()));
  if (!path.is_valid()) clearError();
  if (!path.is_valid() || !PyUnicode_Check(path.ptr()))
    badType("{} must be a path, not {}", name, path.is_valid() ? typeName(path) : typeName(value));
  const std::string text = textOf(path, name);
  if (text.find('\0') != text.npos) badValue("{} must be a path, which has no null character", name);
  return text;
}

nb::list itemsOf(nb::handle value, std::string_view name, std::string_view what) {
  const RunningPython section;
  const nb::object items = nb::steal(PySequence_List(value.ptr()));
  if (items.is_valid()) return nb::borrow<nb::list>(items);
  clearError();
  badType("{} must be {}, not {}", name, what, typeName(value));
}

std::vector<std::string> textsOf(nb::handle value, std::string_view name) {
  if (PyUnicode_Check(value.ptr())) return {textOf(value, name)};
  std::vector<std::string> texts;
  for (const nb::handle item : itemsOf(value, name, "a list of texts")) texts.push_back(textOf(item, name));
  return texts;
}

std::vector<std::string> pathsOf(nb::handle value, std::string_view name) {
  if (PyUnicode_Check(value.ptr())) return {pathOf(value, name)};
  std::vector<std::string> paths;
  for (const nb::handle item : itemsOf(value, name, "a list of paths")) paths.push_back(pathOf(item, name));
  return paths;
}

nb::object anyArrayOf(nb::handle value, std::string_view name, const std::vector<int64_t>& shape) {
  const RunningPython section;
  rejectMasks(value, name);
  try {
    return numpy(hasOnlyDlpack(value) ? "from_dlpack" : "asarray")(value);
  } catch (const nb::python_error& error) {
    if (!isRefusal(error)) throw;
    if (shape.empty()) badType("{} must be an array of numbers, not {}", name, typeName(value));
    badType("{} must be an array of shape {}, not {}", name, shapeText(shape), typeName(value));
  }
}

nb::object arrayOf(nb::handle value, std::string_view name, Elements elements, const std::vector<int64_t>& shape,
                   const char* dtype) {
  const RunningPython section;
  const nb::object array = anyArrayOf(value, name, shape);
  const std::vector<int64_t> given = shapeOf(array);
  // NumPy wraps any object, such as a text or None, in an array without axes.
  if (!fits(given, shape) && given.empty() && !has(array, Elements::Numbers) && !isNumPy(value, numpy("ndarray")))
    badType("{} must be an array of shape {}, not {}", name, shapeText(shape),
            PyUnicode_Check(value.ptr()) ? "a text" : typeName(value));
  if (!fits(given, shape))
    badValue("{} must be an array of shape {}, not {}", name, shapeText(shape), shapeText(given));
  const bool isEmpty = std::find(given.begin(), given.end(), 0) != given.end();  // an empty list has float elements
  if (!isEmpty && !has(array, elements))
    badType("{} must be an array of {}, not {}", name, infoOf(elements).name, dtypeName(array));
  return dtype ? numpy("ascontiguousarray")(array, dtype) : numpy("ascontiguousarray")(array);
}

nb::object rowsWithColumns(nb::handle value, size_t columns) {
  const RunningPython section;
  const bool isList = PyList_Check(value.ptr()) || PyTuple_Check(value.ptr());
  const bool isEmpty = isList ? PySequence_Size(value.ptr()) == 0
                              : nb::hasattr(value, "shape") && value.attr("shape").equal(nb::make_tuple(0));
  return isEmpty ? numpy("empty")(nb::make_tuple(0, columns)) : nb::borrow(value);
}

nb::object numberArrayOf(nb::handle value, std::string_view name) {
  const RunningPython section;
  const nb::object array = anyArrayOf(value, name, {});
  if (!has(array, Elements::Numbers))
    badType("{} must be an array of numbers, not {}", name,
            nb::cast<int>(array.attr("ndim")) == 0 ? typeName(value) : dtypeName(array));
  return array.attr("astype")("float64", nb::arg("copy") = false);
}

nb::object integerArrayOf(nb::handle value, std::string_view name, const char* dtype) {
  const RunningPython section;
  const nb::object array = arrayOf(value, name, Elements::Integers, {-1}), range = numpy("iinfo")(dtype);
  const auto least = nb::cast<int64_t>(range.attr("min")), most = nb::cast<int64_t>(range.attr("max"));
  if (lengthOf(array, 0) > 0)
    for (const char* bound : {"min", "max"})
      integerOf(array.attr(bound)(), fmt::format("each value of {}", name), least, most);
  return array.attr("astype")(dtype, nb::arg("copy") = false);
}

size_t lengthOf(const nb::object& array, size_t axis) {
  return static_cast<size_t>(shapeOf(array)[axis]);
}

FloatArray floatsOf(nb::handle value, std::string_view name, const std::vector<int64_t>& shape, Integers integers) {
  const RunningPython section;
  const Elements elements = integers == Integers::Rejected ? Elements::Floats : Elements::Numbers;
  const nb::object array = arrayOf(value, name, elements, shape);
  FloatArray floats{{}, shapeOf(array)};
  if (normalize(array, integers, floats.values)) return floats;
  rejectOtherSmallIntegers(array, integers, name);
  if (kindOf(array) == 'f' && itemBytes(array) <= 4) {
    floats.values = valuesOf<float>(numpy("ascontiguousarray")(array, "float32"));
    requireFinite(floats.values, name);
    return floats;
  }
  const std::vector<double> numbers = doublesOf(array, name, shape);
  floats.values.reserve(numbers.size());
  for (const double number : numbers) {
    floats.values.push_back(static_cast<float>(number));
    if (!std::isfinite(floats.values.back())) badValue("{} has a number that is too large: {}", name, number);
  }
  return floats;
}

std::vector<double> doublesOf(nb::handle value, std::string_view name, const std::vector<int64_t>& shape) {
  const nb::object array = arrayOf(value, name, Elements::Numbers, shape, "float64");
  std::vector<double> numbers = valuesOf<double>(array);
  requireFinite(numbers, name);
  return numbers;
}

nb::object matrix(const std::array<double, 16>& values) {
  return owned(std::vector<double>(values.begin(), values.end()), {4, 4});
}

}  // namespace latelight::python
