#include "casts.h"

#include <fmt/ranges.h>
#include <nanobind/stl/shared_ptr.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "device_array.h"
#include "options.h"
#include "values.h"
#include "worlds.h"

namespace latelight::python {

namespace {

// Vectors in memory of a NumPy array of this type, which is the argument itself if it is contiguous and has the type.
template <typename T>
class Vectors {
 public:
  Vectors(nb::handle value, std::string_view name)
      : array_(arrayOf(value, name, Elements::Numbers, {-1, 3}, std::is_same_v<T, float> ? "float32" : "float64")) {}
  std::span<const std::array<T, 3>> values() const {
    return {reinterpret_cast<const std::array<T, 3>*>(viewOf<T>(array_).data()), lengthOf(array_, 0)};
  }

 private:
  nb::object array_;
};

bool isFloat32(nb::handle value) {
  return PyObject_HasAttrString(value.ptr(), "dtype") && shown(nb::object(value.attr("dtype"))) == "float32";
}

// An array of hits by its name, and the member of CastTargets that has its memory.
struct HitArray {
  const char* name;
  std::variant<float * CastTargets::*, std::array<float, 2> * CastTargets::*, std::array<float, 3> * CastTargets::*,
               uint32_t * CastTargets::*>
      target;
};
constexpr HitArray kHitArrays[] = {{"distance", &CastTargets::distance},
                                   {"position", &CastTargets::position},
                                   {"normal", &CastTargets::normal},
                                   {"geonormal", &CastTargets::geonormal},
                                   {"uv", &CastTargets::uv},
                                   {"id", &CastTargets::id},
                                   {"part", &CastTargets::part},
                                   {"material", &CastTargets::material},
                                   {"triangle", &CastTargets::triangle},
                                   {"intensity", &CastTargets::intensity}};
static_assert(std::size(kHitArrays) * sizeof(void*) == sizeof(CastTargets));

// The arrays of hits that a call of cast() returns: new ones, or those of `out`.
class HitArrays {
 public:
  // `shape`: of the rays, (R), or (N, R) for worlds.
  HitArrays(std::vector<size_t> shape, nb::handle names, nb::handle out) : shape_(std::move(shape)), out_(out) {
    if (!out.is_none() && !PyDict_Check(out.ptr())) badType("out must be a dict of arrays, not {}", typeName(out));
    if (!names.is_none() && !out.is_none()) badValue("outputs and out name the same arrays: omit one of them");
    if (names.is_none() && out.is_none())
      for (const HitArray& array : kHitArrays) add(array);
    else
      for (const std::string& name : names.is_none() ? textsOf(nb::list(out), "out") : textsOf(names, "outputs"))
        add(named(name));
  }
  const CastTargets& targets() const { return targets_; }
  nb::dict take() { return std::move(arrays_); }

 private:
  static const HitArray& named(const std::string& name) {
    const auto* const found = std::ranges::find(kHitArrays, name, &HitArray::name);
    if (found != std::end(kHitArrays)) return *found;
    std::vector<const char*> names;
    for (const HitArray& array : kHitArrays) names.push_back(array.name);
    const char* const last = names.back();
    names.pop_back();
    badValue("rays have no output \"{}\": they have {} and {}", name, fmt::join(names, ", "), last);
  }

  void add(const HitArray& array) {
    std::visit([&]<typename Value>(Value* CastTargets::*target) { targets_.*target = memory<Value>(array.name); },
               array.target);
  }

  // Returns the memory of an array with a value, or columns, per ray.
  template <typename Value>
  Value* memory(const std::string& name) {
    using Element = std::conditional_t<std::is_same_v<Value, uint32_t>, uint32_t, float>;
    std::vector<size_t> shape = shape_;
    if (sizeof(Value) > sizeof(Element)) shape.push_back(sizeof(Value) / sizeof(Element));
    const nb::object array = out_.is_none() ? made<Element>(shape) : given<Element>(name, shape);
    arrays_[name.c_str()] = array;
    return reinterpret_cast<Value*>(nb::cast<nb::ndarray<Element, nb::c_contig, nb::device::cpu>>(array).data());
  }

  // NumPy's own memory, which is not cleared and in huge pages.
  template <typename Element>
  static nb::object made(const std::vector<size_t>& shape) {
    nb::list lengths;
    for (const size_t length : shape) lengths.append(length);
    return nb::module_::import_("numpy").attr("empty")(nb::tuple(lengths),
                                                       std::is_same_v<Element, float> ? "float32" : "uint32");
  }

  template <typename Element>
  nb::object given(const std::string& name, const std::vector<size_t>& shape) {
    const nb::object array = nb::borrow<nb::object>(out_[name.c_str()]);
    if (isDeviceArray(array)) badValue("out requires on_device=True: its arrays are on the device");
    nb::ndarray<Element, nb::c_contig, nb::device::cpu> view;
    bool fits = nb::try_cast(array, view, false) && view.ndim() == shape.size();
    for (size_t i = 0; fits && i < shape.size(); ++i) fits = view.shape(i) == shape[i];
    if (!fits)
      badValue(
          "out[\"{}\"] must be a contiguous array of {} of shape ({}), as an earlier call for as many rays returned it",
          name, std::is_same_v<Element, float> ? "float32" : "uint32", fmt::join(shape, ", "));
    return array;
  }

  std::vector<size_t> shape_;
  nb::handle out_;
  CastTargets targets_;
  nb::dict arrays_;
};

// Rays in flight, with the arrays that receive their hits, or, if these stay on the device, with their shape.
class SharedCastTicket {
 public:
  using Hits = std::variant<HitArrays, std::vector<size_t>>;
  // `kept`: what the call reads until it has finished.
  SharedCastTicket(std::shared_ptr<SharedRenderer> renderer, CastTicket&& ticket, Hits&& hits,
                   std::unique_ptr<GivenWorlds> kept = nullptr)
      : renderer_(std::move(renderer)), ticket_(std::move(ticket)), hits_(std::move(hits)), kept_(std::move(kept)) {}
  ~SharedCastTicket() {
    try {
      renderer_->use([&](Renderer&) { const CastTicket dropped = std::move(ticket_); });
    } catch (const Error&) {  // in a forked process, where nothing is dropped
    }
  }

  bool done() {
    return renderer_->use([&](Renderer&) { return ticket_.done(); });
  }
  nb::dict take() {
    std::map<std::string, DeviceArray> arrays;
    HitArrays* const onHost = std::get_if<HitArrays>(&hits_);
    renderer_->use([&](Renderer&) {
      if (onHost)
        ticket_.take();
      else
        arrays = ticket_.takeArrays();
    });
    kept_.reset();
    return onHost ? onHost->take() : deviceArrays(std::move(arrays), std::get<1>(hits_), Axes::Rays);
  }

 private:
  std::shared_ptr<SharedRenderer> renderer_;
  CastTicket ticket_;
  Hits hits_;
  std::unique_ptr<GivenWorlds> kept_;
};

template <typename T>
std::shared_ptr<SharedCastTicket> submitVectors(const std::shared_ptr<SharedRenderer>& renderer,
                                                const Vectors<T>& origins, const Vectors<T>& directions, double limit,
                                                nb::handle outputs, nb::handle out, const Options& options) {
  const auto from = origins.values(), along = directions.values();
  if (from.size() != along.size())
    badValue("origins and directions must have equal lengths, not {} and {}", from.size(), along.size());
  HitArrays hits({from.size()}, outputs, out);
  CastTicket ticket = renderer->use(
      [&](Renderer& renderer) { return renderer.submitCast(from, along, hits.targets(), options, limit); });
  return std::make_shared<SharedCastTicket>(renderer, std::move(ticket), std::move(hits));
}

std::shared_ptr<SharedCastTicket> submitRays(const std::shared_ptr<SharedRenderer>& renderer, nb::handle origins,
                                             nb::handle directions, double limit, nb::handle outputs, nb::handle out,
                                             const nb::dict& keywords) {
  const Options options = optionsOf(nb::none(), nb::make_tuple("rgba"), keywords);
  if (isFloat32(origins) && isFloat32(directions))
    return submitVectors<float>(renderer, {origins, "origins"}, {directions, "directions"}, limit, outputs, out,
                                options);
  return submitVectors<double>(renderer, {origins, "origins"}, {directions, "directions"}, limit, outputs, out,
                               options);
}

// The names of the arrays of hits to return: `outputs`, those of `out`, or all.
std::vector<std::string> hitNames(nb::handle outputs, const std::map<std::string, DeviceArray>& out) {
  if (!outputs.is_none() && !out.empty()) badValue("outputs and out name the same arrays: omit one of them");
  std::vector<std::string> names;
  if (!outputs.is_none()) names = textsOf(outputs, "outputs");
  for (const auto& [name, array] : out) names.push_back(name);
  for (const HitArray& array : kHitArrays)
    if (outputs.is_none() && out.empty()) names.push_back(array.name);
  return names;
}

// Submits rays from arrays that may be in CUDA's memory, through worlds or, with one world, through the scene.
std::shared_ptr<SharedCastTicket> submitArrays(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count,
                                               nb::handle origins, nb::handle directions, double limit,
                                               nb::handle outputs, nb::handle out, bool perWorld, nb::dict& optional) {
  const bool onDevice = boolOf(optional.attr("pop")("on_device", false), "on_device");
  // Rays have no cameras. Those of worlds that also describe images are ignored.
  if (perWorld)
    for (const char* name :
         {"camera_to_world", "previous_camera_to_world", "next_camera_to_world", "k", "camera_instances"})
      optional.attr("pop")(name, nb::none());
  WorldCall call = worldCall(renderer, count, nb::cast(Camera{}), optional);
  const bool tensors = isTensor(origins) || isTensor(directions);
  readRays(*call.given, origins, directions, perWorld, tensors ? readerOf(*renderer, call) : 0);
  WorldRays& rays = call.given->rays;
  rays.maxDistance = limit;
  const Options options = optionsOf(nb::none(), nb::make_tuple("rgba"), optional);
  std::vector<size_t> shape{rays.count};
  if (perWorld) shape.insert(shape.begin(), call.given->worlds.count);
  const auto submit = [&](SharedCastTicket::Hits&& hits, const auto& work) {
    CastTicket ticket = renderer->use([&](Renderer& r) { return work(r, completed(call, *renderer, r)); });
    return std::make_shared<SharedCastTicket>(renderer, std::move(ticket), std::move(hits), std::move(call.given));
  };
  if (onDevice) {
    const std::map<std::string, DeviceArray> targets = targetsOf(out);
    const std::vector<std::string> names = hitNames(outputs, targets);
    return submit(std::move(shape), [&](Renderer& r, const Worlds& worlds) {
      return r.submitCast(worlds, rays, names, options, targets);
    });
  }
  HitArrays hits(std::move(shape), outputs, out);
  const CastTargets targets = hits.targets();
  return submit(std::move(hits),
                [&](Renderer& r, const Worlds& worlds) { return r.submitCast(worlds, rays, targets, options); });
}

std::shared_ptr<SharedCastTicket> submitCastWorlds(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count,
                                                   nb::handle origins, nb::handle directions, nb::handle maxDistance,
                                                   nb::handle outputs, nb::handle out, const nb::kwargs& keywords) {
  nb::dict optional;
  optional.update(keywords);
  return submitArrays(renderer, count, origins, directions, numberOf(maxDistance, "max_distance"), outputs, out, true,
                      optional);
}

nb::dict castWorlds(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count, nb::handle origins,
                    nb::handle directions, nb::handle maxDistance, nb::handle outputs, nb::handle out,
                    const nb::kwargs& keywords) {
  return submitCastWorlds(renderer, count, origins, directions, maxDistance, outputs, out, keywords)->take();
}

// Rays and hits that are both in the host's memory require no worlds.
std::shared_ptr<SharedCastTicket> submitCast(const std::shared_ptr<SharedRenderer>& renderer, nb::handle from,
                                             nb::handle along, nb::handle maxDistance, nb::handle outputs,
                                             nb::handle out, const nb::kwargs& keywords) {
  const double limit = numberOf(maxDistance, "max_distance");
  const nb::object origins = rowsWithColumns(from, 3), directions = rowsWithColumns(along, 3);
  nb::dict optional;
  optional.update(keywords);
  const bool onDevice = boolOf(optional.attr("get")("on_device", false), "on_device");
  const bool ordered = !nb::object(optional.attr("get")("stream")).is_none();
  if (isTensor(origins) || isTensor(directions) || onDevice || ordered)
    return submitArrays(renderer, nb::int_(1), origins, directions, limit, outputs, out, false, optional);
  for (const char* name : {"on_device", "stream"}) optional.attr("pop")(name, nb::none());
  return submitRays(renderer, origins, directions, limit, outputs, out, optional);
}

nb::dict cast(const std::shared_ptr<SharedRenderer>& renderer, nb::handle origins, nb::handle directions,
              nb::handle maxDistance, nb::handle outputs, nb::handle out, const nb::kwargs& keywords) {
  return submitCast(renderer, origins, directions, maxDistance, outputs, out, keywords)->take();
}

constexpr const char* kHitsOut = "dict[str, numpy.typing.NDArray[typing.Any]] | dict[str, DeviceArray] | None";
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

}  // namespace

void bindCastTicket(nb::module_& module) {
  nb::class_<SharedCastTicket>(module, "CastTicket", nb::is_weak_referenceable(),
                               "Rays in flight, as returned by Renderer.submit_cast() and submit_cast_worlds().")
      .def_prop_ro("done", &SharedCastTicket::done, "take() would not wait for the device")
      .def("take", &SharedCastTicket::take, nb::sig("def take(self) -> dict[str, typing.Any]"),
           "Waits for the hits and returns them, once, as cast() and cast_worlds() do.");
}

void defineRays(nb::class_<SharedRenderer>& type) {
  const auto signature = [](const char* name, const char* result) {
    return fmt::format(
        "def {}(self, origins: numpy.typing.ArrayLike, directions: numpy.typing.ArrayLike, max_distance: float = "
        "float(\"inf\"), outputs: str | collections.abc.Sequence[str] | None = None, out: {} = None, *, on_device: "
        "bool = False, stream: typing.Any | None = None{}) -> {}",
        name, kHitsOut, optionParameters(), result);
  };
  const std::string now = signature("cast", "dict[str, typing.Any]"), later = signature("submit_cast", "CastTicket");
  type.def("cast", &cast, argument("origins"), argument("directions"), argument("max_distance") = kUnlimited,
           argument("outputs") = nb::none(), argument("out") = nb::none(), nb::arg("options"), nb::sig(now.c_str()),
           "Casts rays through the scene. origins and directions are arrays (N, 3) in the frame of axes; directions "
           "may have\nany length.\n\nReturns arrays of N values by name: distance (meters; infinite for a ray that "
           "hits nothing), position, normal,\ngeonormal, uv, id, part and material as the outputs of these names, "
           "triangle, the index in the part's mesh, and\nintensity, from 0 to 1: the reflectance at normal incidence "
           "times the cosine of the angle of incidence.\noutputs: the names of those to return; None: all. out: "
           "arrays that an earlier call for as many rays returned; they\nreceive the values and are returned. Those on "
           "the device are this renderer's, and no two share memory.\n"
           "origins and directions may be in CUDA's memory (torch, JAX, CuPy, Warp).\non_device: leave the hits in the "
           "device's memory, as DeviceArray; stream: as for render_worlds().\nThe options time, animation, "
           "data_surfaces, axes and position_origin apply.");
  type.def("submit_cast", &submitCast, argument("origins"), argument("directions"),
           argument("max_distance") = kUnlimited, argument("outputs") = nb::none(), argument("out") = nb::none(),
           nb::arg("options"), nb::sig(later.c_str()),
           "The same as cast(), and returns a CastTicket while the device casts the rays, which are copied. Meanwhile, "
           "the scene may\nbe edited, and more rays and frames submitted. The arrays of out may change until the "
           "ticket is taken.");
}

void defineWorldRays(nb::class_<SharedRenderer>& type) {
  const auto signature = [](const char* name, const char* result) {
    return fmt::format(
        "def {}(self, count: int, origins: typing.Any, directions: typing.Any, max_distance: float = float(\"inf\"), "
        "outputs: str | collections.abc.Sequence[str] | None = None, out: {} = None, *{}, on_device: bool = False, "
        "stream: typing.Any | None = None{}) -> {}",
        name, kHitsOut, worldParameters(), optionParameters({"environment_rotation", "environment_intensity"}), result);
  };
  const std::string now = signature("cast_worlds", "dict[str, typing.Any]");
  const std::string later = signature("submit_cast_worlds", "CastTicket");
  type.def(
      "cast_worlds", &castWorlds, argument("count"), argument("origins"), argument("directions"),
      argument("max_distance") = kUnlimited, argument("outputs") = nb::none(), argument("out") = nb::none(),
      nb::arg("options"), nb::sig(now.c_str()),
      "Casts rays through N worlds, as cast() does through the scene. origins and directions are arrays (N, R, 3), in "
      "NumPy's\nor CUDA's memory, both of the same type; hits are arrays (N, R) or (N, R, 3), and (N, R, 2) for uv. "
      "The other arguments are\nthose of cast() and render_worlds(); cameras, lights and environments have no effect. "
      "A ray of a world with values that\nare not finite hits nothing.");
  type.def("submit_cast_worlds", &submitCastWorlds, argument("count"), argument("origins"), argument("directions"),
           argument("max_distance") = kUnlimited, argument("outputs") = nb::none(), argument("out") = nb::none(),
           nb::arg("options"), nb::sig(later.c_str()),
           "The same as cast_worlds(), and returns a CastTicket while the device casts the rays. Meanwhile, the scene "
           "may be edited,\nand more rays and frames submitted. The arrays of out may change until the ticket is "
           "taken.");
}

}  // namespace latelight::python
