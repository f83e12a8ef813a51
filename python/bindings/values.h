// Python values as C++ ones. Each function names the argument in the one sentence that refuses a value. An exception
// that the value's own code raises (__float__, __array__, __iter__ and so on) passes unchanged.
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

// A value of the wrong type, or an argument that there is not: Python's TypeError as well.
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

// An argument that takes all values, None too: what does not fit is refused in a sentence of its own.
inline auto argument(const char* name) {
  return nb::arg(name).none();
}

std::string typeName(nb::handle value);
std::string shown(const nb::object& value);  // as str() gives it

bool boolOf(nb::handle value, std::string_view name);
double numberOf(nb::handle value, std::string_view name);
float floatOf(nb::handle value, std::string_view name);
int64_t integerOf(nb::handle value, std::string_view name, int64_t least, int64_t most);
std::string textOf(nb::handle value, std::string_view name);
std::string pathOf(nb::handle value, std::string_view name);  // a text or os.PathLike
std::vector<std::string> pathsOf(nb::handle value, std::string_view name);  // one, or a list of them
std::vector<std::string> textsOf(nb::handle value, std::string_view name);
// The items of anything iterable. `what`: the list in the sentence that refuses another value, "a list of texts".
nb::list itemsOf(nb::handle value, std::string_view name, std::string_view what);

// The object behind a Python one, whose class is called `what` in the sentence: "a Camera".
template <typename T>
const T& objectOf(nb::handle value, std::string_view name, std::string_view what) {
  const T* object = nullptr;
  if (!nb::try_cast<const T*>(value, object, false) || !object)
    badType("{} must be {}, not {}", name, what, typeName(value));
  return *object;
}

// The elements that an array argument may have, by NumPy's kinds: no bool, no complex numbers, no objects.
enum class Elements {
  Numbers,   // floats and integers
  Floats,    // no integers
  Integers,  // signed or unsigned
  Uint8,
};

// Anything that NumPy makes an array of, as a contiguous one in this machine's byte order. `shape`: lengths, -1 for
// any. `dtype`: that it is converted to; null: it keeps its own. Masked values are refused, since NumPy would drop the
// mask.
nb::object arrayOf(nb::handle value, std::string_view name, Elements elements, const std::vector<int64_t>& shape,
                   const char* dtype = nullptr);
size_t lengthOf(const nb::object& array, size_t axis);

template <typename T>
nb::ndarray<const T, nb::c_contig, nb::device::cpu> viewOf(const nb::object& array) {
  return nb::cast<nb::ndarray<const T, nb::c_contig, nb::device::cpu>>(array);
}

// The meaning of integers where floats are stored.
enum class Integers {
  Plain,             // as numbers
  Normalized,        // uint8 / 255 and uint16 / 65535, as glTF stores colors and texture coordinates
  SignedNormalized,  // int8 / 127 and int16 / 32767, at least -1, as KHR_mesh_quantization stores normals and tangents
  Refused,
};

// Finite numbers, row by row.
struct FloatArray {
  std::vector<float> values;
  std::vector<int64_t> shape;
};
FloatArray floatsOf(nb::handle value, std::string_view name, const std::vector<int64_t>& shape,
                    Integers integers = Integers::Plain);

// The same, as float64.
std::vector<double> doublesOf(nb::handle value, std::string_view name, const std::vector<int64_t>& shape);

// Rows of N finite numbers.
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

// A NumPy array that owns the vector's memory.
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
