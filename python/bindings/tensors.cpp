#include "tensors.h"

#include "interpreter.h"
#include "values.h"

namespace latelight::python {

namespace {

using Element = WorldArray::Element;

bool isContiguous(const std::vector<int64_t>& shape, const std::vector<int64_t>& strides) {
  int64_t expected = 1;
  for (size_t axis = shape.size(); axis-- > 0;) {
    if (shape[axis] != 1 && strides[axis] != expected) return false;
    expected *= shape[axis];
  }
  return true;
}

[[noreturn]] void rejectElements(const char* name, const std::string& elements) {
  badType(
      "{} must be an array of float32 or float64 in CUDA's memory, or of bool for exists, or of int32 or int64 for "
      "indices, not of {}",
      name, elements);
}

void requireContiguous(const char* name, const std::vector<int64_t>& shape, const std::vector<int64_t>& strides) {
  if (!isContiguous(shape, strides))
    badValue("{} must be contiguous in CUDA's memory, in C order: pass a copy, such as torch's contiguous()", name);
}

uint64_t bytesOf(Element element) {
  if (element == Element::Uint8) return 1;
  return element == Element::Float64 || element == Element::Int64 ? 8 : 4;
}

void setBytes(Tensor& tensor) {
  tensor.bytes = bytesOf(tensor.element);
  for (const int64_t length : tensor.shape) tensor.bytes *= static_cast<uint64_t>(length);
}

bool hasDlpack(nb::handle value) {
  return nb::hasattr(value, "__dlpack__") && nb::hasattr(value, "__dlpack_device__");
}

bool onCuda(nb::handle value) {
  constexpr int kManaged = 13;  // kDLCUDAManaged
  const nb::tuple device = nb::cast<nb::tuple>(value.attr("__dlpack_device__")());
  const int type = nb::cast<int>(nb::int_(nb::handle(device[0])));
  return type == nb::device::cuda::value || type == kManaged;
}

Tensor fromDlpack(nb::handle value, const char* name, uintptr_t reader) {
  // The producer makes the reader's stream wait for its own work (the array API's __dlpack__).
  const nb::object capsule = value.attr("__dlpack__")(nb::arg("stream") = reader);
  const auto array = nb::cast<nb::ndarray<nb::ro>>(capsule);
  Tensor tensor;
  tensor.pointer = reinterpret_cast<uintptr_t>(array.data());
  tensor.device = array.device_id();
  std::vector<int64_t> strides;
  for (size_t axis = 0; axis < array.ndim(); ++axis) {
    tensor.shape.push_back(static_cast<int64_t>(array.shape(axis)));
    strides.push_back(array.stride(axis));
  }
  const nb::dlpack::dtype type = array.dtype();
  const auto code = static_cast<nb::dlpack::dtype_code>(type.code);
  if (code == nb::dlpack::dtype_code::Float && type.bits == 32)
    tensor.element = Element::Float32;
  else if (code == nb::dlpack::dtype_code::Float && type.bits == 64)
    tensor.element = Element::Float64;
  else if ((code == nb::dlpack::dtype_code::Bool || code == nb::dlpack::dtype_code::UInt) && type.bits == 8)
    tensor.element = Element::Uint8;
  else if (code == nb::dlpack::dtype_code::Int && type.bits == 32)
    tensor.element = Element::Int32;
  else if (code == nb::dlpack::dtype_code::Int && type.bits == 64)
    tensor.element = Element::Int64;
  else
    rejectElements(name, nb::hasattr(value, "dtype") ? shown(value.attr("dtype")) : "another type");
  requireContiguous(name, tensor.shape, strides);
  setBytes(tensor);
  tensor.view = array;
  tensor.owner = nb::borrow(value);
  return tensor;
}

// Version 3 of the interface: numba.readthedocs.io/en/stable/cuda/cuda_array_interface.html.
Tensor fromInterface(nb::handle value, const char* name) {
  const nb::dict interface = nb::cast<nb::dict>(value.attr("__cuda_array_interface__"));
  Tensor tensor;
  tensor.pointer = nb::cast<uintptr_t>(nb::cast<nb::tuple>(interface["data"])[0]);
  for (const nb::handle length : nb::cast<nb::tuple>(interface["shape"]))
    tensor.shape.push_back(nb::cast<int64_t>(length));
  const auto type = nb::cast<std::string>(interface["typestr"]);
  if (type == "<f4")
    tensor.element = Element::Float32;
  else if (type == "<f8")
    tensor.element = Element::Float64;
  else if (type == "|b1" || type == "|u1")
    tensor.element = Element::Uint8;
  else if (type == "<i4")
    tensor.element = Element::Int32;
  else if (type == "<i8")
    tensor.element = Element::Int64;
  else
    rejectElements(name, type);
  setBytes(tensor);
  const nb::object strides = interface.attr("get")("strides");
  if (!strides.is_none()) {
    const auto size = static_cast<int64_t>(bytesOf(tensor.element));
    std::vector<int64_t> elements;
    for (const nb::handle bytes : nb::cast<nb::tuple>(strides)) elements.push_back(nb::cast<int64_t>(bytes) / size);
    requireContiguous(name, tensor.shape, elements);
  }
  const nb::object stream = interface.attr("get")("stream");
  if (!stream.is_none()) tensor.writer = nb::cast<uintptr_t>(stream);
  tensor.device = -1;  // the pointer's
  tensor.owner = nb::borrow(value);
  return tensor;
}

}  // namespace

bool isTensor(nb::handle value) {
  if (value.is_none()) return false;
  const RunningPython section;
  return hasDlpack(value) ? onCuda(value) : nb::hasattr(value, "__cuda_array_interface__");
}

Tensor tensorOf(nb::handle value, const char* name, uintptr_t reader) {
  const RunningPython section;
  return hasDlpack(value) ? fromDlpack(value, name, reader) : fromInterface(value, name);
}

uintptr_t streamOf(nb::handle value) {
  const RunningPython section;
  nb::object number = nb::borrow(value);
  for (const char* attribute : {"cuda_stream", "ptr"})  // torch and Warp; CuPy
    if (!PyLong_Check(value.ptr()) && nb::hasattr(value, attribute)) number = value.attr(attribute);
  const int64_t stream = integerOf(number, "stream", 0, INT64_MAX);
  return stream == 0 ? kLegacyStream : static_cast<uintptr_t>(stream);
}

}  // namespace latelight::python
