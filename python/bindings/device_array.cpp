// Binds the class DeviceArray.
#include "device_array.h"

#include <fmt/ranges.h>
#include <latelight/latelight.h>

#include "bindings.h"
#include "cuda.h"
#include "values.h"

namespace latelight::python {

namespace {

// DLPack's device types.
constexpr int kOnHost = nb::device::cpu::value, kOnCuda = nb::device::cuda::value;

constexpr nb::dlpack::dtype kHalf{static_cast<uint8_t>(nb::dlpack::dtype_code::Float), 16, 1};

struct ElementInfo {
  nb::dlpack::dtype dtype;
  const char* name;
  const char* typeString;  // as in __cuda_array_interface__
};
const ElementInfo& infoOf(DeviceArray::Element element) {
  static const ElementInfo kInfos[] = {{nb::dtype<float>(), "float32", "<f4"},
                                       {nb::dtype<uint32_t>(), "uint32", "<u4"},
                                       {nb::dtype<uint8_t>(), "uint8", "|u1"},
                                       {kHalf, "float16", "<f2"},
                                       {nb::dtype<uint16_t>(), "uint16", "<u2"}};
  return kInfos[static_cast<size_t>(element)];  // in the order of the enumeration
}

struct PlacedArray {
  DeviceArray array;
  std::vector<size_t> shape;
  void* pointer = nullptr;
  int deviceType = kOnHost, device = 0;
};

// The shape in Python: an axis of a single channel is left out.
std::vector<size_t> shapeOf(const DeviceArray& array, const std::vector<size_t>& views, Axes axes) {
  std::vector<size_t> shape = views;
  const size_t channels = array.channelsFirst ? 1 : 3;
  for (size_t axis = axes == Axes::Images ? 1 : 3; axis < 4; ++axis)
    if (axis != channels || array.shape[axis] > 1) shape.push_back(array.shape[axis]);
  return shape;
}

PlacedArray placed(const DeviceArray& array, const std::vector<size_t>& views, Axes axes) {
  PlacedArray placed{.array = array, .shape = shapeOf(array, views, axes)};
  if (const void* host = placed.array.host()) {
    placed.pointer = const_cast<void*>(host);
    return placed;
  }
  const CudaPointer place = cudaPointerOf(placed.array);
  placed.pointer = place.pointer;
  placed.deviceType = kOnCuda;
  placed.device = place.device;
  return placed;
}

// Returns the array for another library, which keeps `self` alive while it uses the memory.
template <typename... Framework>
nb::object viewOf(nb::handle self) {
  const auto& a = nb::cast<const PlacedArray&>(self);
  return nb::cast(nb::ndarray<Framework...>(a.pointer, a.shape.size(), a.shape.data(), self, nullptr,
                                            infoOf(a.array.element).dtype, a.deviceType, a.device));
}

nb::object toNumPy(nb::handle self) {
  if (nb::cast<const PlacedArray&>(self).deviceType != kOnHost)
    badType("the array is in a device's memory: give it to a library that computes there, or render without on_device");
  return viewOf<nb::numpy>(self);
}

// NumPy's protocol. Without it, numpy.asarray() would return an array of shape () that holds the object.
nb::object toNumPyArray(nb::handle self, nb::handle dtype, nb::handle copy) {
  if (nb::cast<const PlacedArray&>(self).deviceType != kOnHost)
    badType(
        "the array is in a device's memory, which NumPy cannot read: give it to a library that computes there, as "
        "torch.from_dlpack(array) does, or render without on_device");
  const nb::object array = viewOf<nb::numpy>(self);
  const bool converts =
      !dtype.is_none() && !array.attr("dtype").equal(nb::module_::import_("numpy").attr("dtype")(dtype));
  if (converts && copy.ptr() == Py_False)
    badValue("copy=False is impossible, because the elements must be converted to another type");
  if (converts) return array.attr("astype")(dtype);
  return copy.ptr() == Py_True ? nb::object(array.attr("copy")()) : array;
}

nb::tuple shapeTuple(const PlacedArray& a) {
  nb::list shape;
  for (const size_t length : a.shape) shape.append(length);
  return nb::tuple(shape);
}

nb::dict cudaInterface(const PlacedArray& a) {
  if (a.deviceType != kOnCuda) throw nb::attribute_error("the array is not in CUDA's memory");
  nb::dict interface;
  interface["shape"] = shapeTuple(a);
  interface["typestr"] = infoOf(a.array.element).typeString;
  interface["data"] = nb::make_tuple(reinterpret_cast<uintptr_t>(a.pointer), false);
  interface["strides"] = nb::none();
  interface["version"] = 3;
  return interface;
}

}  // namespace

nb::dict deviceArrays(std::map<std::string, DeviceArray>&& arrays, const std::vector<size_t>& views, Axes axes) {
  nb::dict all;
  for (auto& [name, array] : arrays) all[name.c_str()] = nb::cast(placed(array, views, axes));
  return all;
}

nb::dict hostArrays(const std::map<std::string, DeviceArray>& arrays, const std::vector<size_t>& views) {
  const nb::object empty = nb::module_::import_("numpy").attr("empty");
  nb::dict all;
  for (const auto& [name, array] : arrays) {
    nb::list shape;
    for (const size_t length : shapeOf(array, views, Axes::Images)) shape.append(length);
    const nb::object copy = empty(nb::tuple(shape), infoOf(array.element).name);
    const auto bytes = nb::cast<nb::ndarray<nb::c_contig, nb::device::cpu>>(copy);
    array.copyToHost({static_cast<std::byte*>(bytes.data()), bytes.nbytes()});
    all[name.c_str()] = copy;
  }
  return all;
}

bool isDeviceArray(nb::handle value) {
  return nb::isinstance<PlacedArray>(value);
}

std::map<std::string, DeviceArray> targetsOf(nb::handle value) {
  std::map<std::string, DeviceArray> targets;
  if (value.is_none()) return targets;
  if (!nb::hasattr(value, "items")) badType("out must be what a call with on_device returned, not {}", typeName(value));
  for (const nb::handle item : value.attr("items")()) {
    const nb::tuple pair = nb::cast<nb::tuple>(item);
    const auto& target = objectOf<PlacedArray>(pair[1], "each array of out", "a DeviceArray");
    targets[textOf(pair[0], "the name of an array of out")] = target.array;
  }
  return targets;
}

void bindDeviceArray(nb::module_& module) {
  nb::class_<PlacedArray> type(
      module, "DeviceArray",
      "An output in the memory of the renderer's device, (V, H, W) or (V, H, W, C); of one "
      "camera without V. Rows from the top.\n\n"
      "torch.from_dlpack(array), cupy.from_dlpack(array), jax.dlpack.from_dlpack(array) and, on "
      "a CPU device,\nnumpy.asarray(array) share its memory without a copy and keep it as long "
      "as they use it. It is complete when it is\nreturned, so no stream has to wait. After "
      "its release, the renderer reuses its memory, after the work that CUDA has\nqueued on "
      "the device by then.");
  type.def_prop_ro("shape", &shapeTuple, nb::sig("def shape(self) -> tuple[int, ...]"))
      .def_prop_ro(
          "dtype",
          [](const PlacedArray& a) {
            return nb::module_::import_("numpy").attr("dtype")(infoOf(a.array.element).name);
          },
          nb::sig("def dtype(self) -> numpy.dtype[typing.Any]"),
          "float32, float16, uint32, uint16 or uint8. It equals its name: array.dtype == \"float32\".")
      .def_prop_ro(
          "device",
          [](const PlacedArray& a) { return a.deviceType == kOnHost ? "cpu" : fmt::format("cuda:{}", a.device); },
          "\"cpu\" or \"cuda:0\", as torch names it.")
      // Before numpy(), which hides the module of that name in the rest of the stub's class.
      .def("__array__", &toNumPyArray, nb::arg("dtype") = nb::none(), nb::arg("copy") = nb::none(),
           nb::sig("def __array__(self, dtype: typing.Any = None, copy: bool | None = None) -> "
                   "numpy.typing.NDArray[typing.Any]"))
      .def("numpy", &toNumPy, nb::sig("def numpy(self) -> numpy.typing.NDArray[typing.Any]"),
           "The array as NumPy's, without a copy: of CPU devices.")
      .def(
          "__dlpack__",
          [](nb::handle self, nb::kwargs asked) { return viewOf<nb::array_api>(self).attr("__dlpack__")(**asked); },
          nb::arg("asked"), nb::sig("def __dlpack__(self, **asked: typing.Any) -> typing.Any"))
      .def(
          "__dlpack_device__", [](const PlacedArray& a) { return nb::make_tuple(a.deviceType, a.device); },
          nb::sig("def __dlpack_device__(self) -> tuple[int, int]"))
      .def_prop_ro("__cuda_array_interface__", &cudaInterface)
      .def("__repr__", [](const PlacedArray& a) {
        return fmt::format("DeviceArray({}, {}, {})", fmt::join(a.shape, "x"), infoOf(a.array.element).name,
                           a.deviceType == kOnHost ? "cpu" : fmt::format("cuda:{}", a.device));
      });
}

}  // namespace latelight::python
