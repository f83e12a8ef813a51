// Python values as C++ ones. Each function names the argument in the one sentence that refuses a value.
#pragma once

#include <fmt/format.h>
#include <latelight/latelight.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <array>
#include <cstring>
#include <string>
#include <string_view>
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
std::vector<std::string> textsOf(nb::handle value, std::string_view name);

// The object behind a Python one, whose class is called `what` in the sentence: "a Camera".
template <typename T>
const T& objectOf(nb::handle value, std::string_view name, std::string_view what) {
  const T* object = nullptr;
  if (!nb::try_cast<const T*>(value, object, false) || !object)
    badType("{} must be {}, not {}", name, what, typeName(value));
  return *object;
}

// Anything that NumPy makes an array of, as a contiguous one. `kinds`: of dtypes that are taken, by NumPy's letters;
// `shape`: lengths, -1 for any.
nb::object arrayOf(nb::handle value, std::string_view name, const char* dtype, std::string_view kinds,
                   const std::vector<int64_t>& shape);
size_t lengthOf(const nb::object& array, size_t axis);

template <typename T>
nb::ndarray<const T, nb::c_contig, nb::device::cpu> viewOf(const nb::object& array) {
  return nb::cast<nb::ndarray<const T, nb::c_contig, nb::device::cpu>>(array);
}

void checkFinite(const float* values, size_t count, std::string_view name);
void checkFinite(const double* values, size_t count, std::string_view name);

// Rows of N finite numbers.
template <size_t N>
std::vector<std::array<float, N>> rowsOf(nb::handle value, std::string_view name) {
  const nb::object array = arrayOf(value, name, "float32", "fiu", {-1, N});
  std::vector<std::array<float, N>> rows(lengthOf(array, 0));
  if (rows.empty()) return rows;
  const auto view = viewOf<float>(array);
  checkFinite(view.data(), N * rows.size(), name);
  std::memcpy(rows.data(), view.data(), sizeof(rows[0]) * rows.size());
  return rows;
}

template <typename T, size_t N>
std::array<T, N> numbersOf(nb::handle value, std::string_view name) {
  const nb::object array = arrayOf(value, name, "float64", "fiu", {N});
  const auto view = viewOf<double>(array);
  checkFinite(view.data(), N, name);
  std::array<T, N> numbers;
  for (size_t i = 0; i < N; ++i) numbers[i] = static_cast<T>(view.data()[i]);
  return numbers;
}

template <size_t Rows, size_t Columns>
std::array<double, Rows * Columns> matrixOf(nb::handle value, std::string_view name) {
  const nb::object array = arrayOf(value, name, "float64", "fiu", {Rows, Columns});
  const auto view = viewOf<double>(array);
  checkFinite(view.data(), Rows * Columns, name);
  std::array<double, Rows * Columns> numbers;
  std::memcpy(numbers.data(), view.data(), sizeof(numbers));
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
