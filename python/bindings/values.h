// Converts Python values to C++. Each function names the argument in the message that rejects a value. Exceptions from
// the value's own code (__float__, __array__, __iter__ and so on) pass unchanged.
#pragma once

#include <fmt/format.h>
#include <latelight/latelight.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace latelight::python {

namespace nb = nanobind;

// A value of the wrong type, or an unknown argument. It is also a Python TypeError.
struct TypeMistake : Error {
  explicit TypeMistake(const std::string& sentence) : Error(ExitCode::Usage, sentence) {}
};

template <typename... Args>
[[noreturn]] void badType(fmt::format_string<Args...> format, Args&&... args) {
  throw TypeMistake(fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
[[noreturn]] void badValue(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(ExitCode::Usage, fmt::format(format, std::forward<Args>(args)...));
}

// An argument that accepts all values, including None, so that invalid ones are rejected with our own message.
inline auto argument(const char* name) {
  return nb::arg(name).none();
}

std::string typeName(nb::handle value);
std::string shown(const nb::object& value);  // the result of str()

bool boolOf(nb::handle value, std::string_view name);
double numberOf(nb::handle value, std::string_view name);
float floatOf(nb::handle value, std::string_view name);
int64_t integerOf(nb::handle value, std::string_view name, int64_t least, int64_t most);
std::string textOf(nb::handle value, std::string_view name);
std::string pathOf(nb::handle value, std::string_view name);                // a str or os.PathLike
std::vector<std::string> pathsOf(nb::handle value, std::string_view name);  // one, or a list of them
std::vector<std::string> textsOf(nb::handle value, std::string_view name);
// Returns the items of any iterable. `what` names the expected list in the message: "a list of texts".
nb::list itemsOf(nb::handle value, std::string_view name, std::string_view what);

// Returns the C++ object of a Python object. `what` names its class in the message: "a Camera".
template <typename T>
const T& objectOf(nb::handle value, std::string_view name, std::string_view what) {
  const T* object = nullptr;
  if (!nb::try_cast<const T*>(value, object, false) || !object)
    badType("{} must be {}, not {}", name, what, typeName(value));
  return *object;
}

// The element types that an array argument accepts, by NumPy's kinds. Bool, complex numbers and objects are never
// accepted.
enum class Elements {
  Numbers,   // floats and integers
  Floats,    // no integers
  Integers,  // signed or unsigned
  Uint8,
};

// Lengths of axes that a shape leaves open, by their names in messages. -1 is any length, too: messages name the first
// such axis N, and the second one M.
enum OpenLength : int64_t {
  kAnyLength = -1,
  kHeightLength = -2,
  kWidthLength = -3,
  kChannelLength = -4,
  kRowLength = -5
};

// Returns a shape for messages, as "(H, W, 3)".
std::string shapeText(const std::vector<int64_t>& shape);

// Converts anything that NumPy accepts, also by DLPack, to an array of any type. `shape` is only for messages; empty:
// any shape. Masked values are rejected, because NumPy would drop the mask.
nb::object anyArrayOf(nb::handle value, std::string_view name, const std::vector<int64_t>& shape);
// Converts anything that NumPy accepts, also by DLPack, to a contiguous array in this machine's byte order. `shape`
// holds lengths, also open ones. `dtype` is the type to convert to; null keeps the array's own. Masked values are
// rejected, because NumPy would drop the mask.
nb::object arrayOf(nb::handle value, std::string_view name, Elements elements, const std::vector<int64_t>& shape,
                   const char* dtype = nullptr);
// Returns the value, or for an empty list an array (0, columns): NumPy would make it an array without an axis of
// columns.
nb::object rowsWithColumns(nb::handle value, size_t columns);
// Converts anything that NumPy accepts to a float64 array with any number of axes. Its numbers may be infinite or NaN.
nb::object numberArrayOf(nb::handle value, std::string_view name);
// Converts a list of integers to an integer type of NumPy. Rejects integers out of its range, which NumPy would wrap.
nb::object integerArrayOf(nb::handle value, std::string_view name, const char* dtype);
size_t lengthOf(const nb::object& array, size_t axis);

template <typename T>
nb::ndarray<const T, nb::c_contig, nb::device::cpu> viewOf(const nb::object& array) {
  return nb::cast<nb::ndarray<const T, nb::c_contig, nb::device::cpu>>(array);
}

// The meaning of integers in arrays of floats.
enum class Integers {
  Plain,             // as numbers
  Normalized,        // uint8 / 255 and uint16 / 65535, as glTF stores colors and texture coordinates
  SignedNormalized,  // int8 / 127 and int16 / 32767, at least -1, as KHR_mesh_quantization stores normals and tangents
  Rejected,
};

// Finite numbers in row-major order.
struct FloatArray {
  std::vector<float> values;
  std::vector<int64_t> shape;
};
FloatArray floatsOf(nb::handle value, std::string_view name, const std::vector<int64_t>& shape,
                    Integers integers = Integers::Plain);

// Same as floatsOf(), with float64.
std::vector<double> doublesOf(nb::handle value, std::string_view name, const std::vector<int64_t>& shape);

// Returns rows of N finite numbers.
template <size_t N>
std::vector<std::array<float, N>> rowsOf(nb::handle value, std::string_view name, Integers integers = Integers::Plain) {
  const FloatArray array = floatsOf(value, name, {-1, N}, integers);
  std::vector<std::array<float, N>> rows(static_cast<size_t>(array.shape[0]));
  if (!rows.empty()) std::memcpy(rows.data(), array.values.data(), sizeof(rows[0]) * rows.size());
  return rows;
}

template <typename T, size_t N>
std::array<T, N> numbersOf(nb::handle value, std::string_view name) {
  std::array<T, N> numbers;
  if constexpr (std::is_same_v<T, float>)
    std::ranges::copy(floatsOf(value, name, {N}).values, numbers.begin());
  else
    std::ranges::copy(doublesOf(value, name, {N}), numbers.begin());
  return numbers;
}

template <size_t Rows, size_t Columns>
std::array<double, Rows * Columns> matrixOf(nb::handle value, std::string_view name) {
  std::array<double, Rows * Columns> numbers;
  std::ranges::copy(doublesOf(value, name, {Rows, Columns}), numbers.begin());
  return numbers;
}

template <typename T, size_t N>
nb::tuple tupleOf(const std::array<T, N>& values) {
  nb::list list;
  for (const T value : values) list.append(value);
  return nb::tuple(list);
}

// Returns a NumPy array that owns the vector's memory.
template <typename T>
nb::object owned(std::vector<T>&& values, const std::vector<size_t>& shape) {
  auto* kept = new std::vector<T>(std::move(values));
  const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(kept->data(), shape.size(), shape.data(), owner));
}
template <size_t N>
nb::object ownedRows(const std::vector<std::array<float, N>>& rows) {
  std::vector<float> values(N * rows.size());
  std::memcpy(values.data(), rows.data(), sizeof(float) * values.size());
  return owned(std::move(values), {rows.size(), N});
}
nb::object matrix(const std::array<double, 16>& values);

}  // namespace latelight::python
