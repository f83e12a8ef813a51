// Binds the classes Renderer and Ticket.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>

#include "bindings.h"
#include "cameras.h"
#include "casts.h"
#include "device_array.h"
#include "interpreter.h"
#include "labels.h"
#include "lidar.h"
#include "options.h"
#include "scene.h"
#include "shared_renderer.h"
#include "values.h"
#include "worlds.h"

namespace latelight::python {

namespace {

// --- frames ---------------------------------------------------------------------------------------------------------

nb::object outputArray(Aov&& aov, size_t height, size_t width) {
  std::vector<size_t> shape{height, width};
  if (aov.channels > 1) shape.push_back(aov.channels);
  return aov.ids.empty() ? owned(std::move(aov.values), shape) : owned(std::move(aov.ids), shape);
}

nb::dict arraysOf(Frame&& frame) {
  nb::dict arrays;
  if (!frame.rgba.empty()) arrays["rgba"] = owned(std::move(frame.rgba), {frame.height, frame.width, 4});
  for (auto& [name, aov] : frame.aovs) arrays[name.c_str()] = outputArray(std::move(aov), frame.height, frame.width);
  return arrays;
}

// The views of a call: the lengths of the axes before those of the images.
struct Views {
  std::vector<size_t> shape;      // empty: a single camera; (V); (N, C) for worlds
  std::vector<uint32_t> invalid;  // worlds
  bool worlds() const { return shape.size() == 2; }
};

nb::object framesOf(std::vector<Frame>&& frames, const Views& views) {
  const RunningPython section;
  const nb::module_ module = nb::module_::import_("latelight.frames");
  const nb::object type = module.attr("Frame");
  nb::list all;
  for (Frame& frame : frames) {
    const float exposure = frame.exposure;
    all.append(type(arraysOf(std::move(frame)), exposure));
  }
  if (views.shape.empty()) return nb::object(all[0]);
  if (views.worlds()) return module.attr("WorldFrames")(all, views.shape[1], nb::cast(views.invalid));
  return module.attr("Frames")(all);
}

// The factors as a sequence. Thousands of views usually share one, for which a single object is enough.
nb::object exposuresOf(const std::vector<float>& exposures) {
  const auto isFirst = [&](float exposure) { return exposure == exposures.front(); };
  if (!std::ranges::all_of(exposures, isFirst) || exposures.empty()) return nb::cast(exposures);
  const nb::tuple one = nb::make_tuple(exposures.front());
  return nb::steal(PySequence_Repeat(one.ptr(), static_cast<Py_ssize_t>(exposures.size())));
}

nb::object deviceFramesOf(std::map<std::string, DeviceArray>&& arrays, const Views& views,
                          const std::vector<float>& exposures) {
  const RunningPython section;
  const nb::module_ module = nb::module_::import_("latelight.frames");
  const nb::dict placed = deviceArrays(std::move(arrays), views.shape);
  if (views.worlds()) return module.attr("DeviceWorldFrames")(placed, nb::cast(views.invalid), exposuresOf(exposures));
  return module.attr("DeviceFrames")(placed, exposuresOf(exposures));
}

// Frames on the host with other formats or another order of axes than the usual ones.
nb::object formattedFramesOf(const std::map<std::string, DeviceArray>& arrays, const Views& views,
                             const std::vector<float>& exposures) {
  const RunningPython section;
  const nb::module_ module = nb::module_::import_("latelight.frames");
  const bool channelsFirst = !arrays.empty() && arrays.begin()->second.channelsFirst;
  return module.attr("frames_of_arrays")(hostArrays(arrays, views.shape), views.shape.size(), nb::cast(exposures),
                                         nb::cast(views.invalid), channelsFirst);
}

// Where a call leaves its results, and in which form.
struct Destination {
  bool onDevice = false, formatted = false;
  Results results = Results::ToHost;
  std::map<std::string, DeviceArray> targets{};
};

class SharedTicket {
 public:
  // `kept`: what the call reads until it has finished.
  SharedTicket(std::shared_ptr<SharedRenderer> renderer, Ticket&& ticket, Views views, const Destination& destination,
               std::unique_ptr<GivenWorlds> kept = nullptr)
      : renderer_(std::move(renderer)),
        ticket_(std::move(ticket)),
        views_(std::move(views)),
        onDevice_(destination.onDevice),
        formatted_(destination.formatted),
        kept_(std::move(kept)) {}
  ~SharedTicket() {
    try {
      renderer_->use([&](Renderer&) { const Ticket dropped = std::move(ticket_); });
    } catch (const Error&) {  // in a forked process, where nothing is dropped
    }
  }

  bool done() {
    return renderer_->use([&](Renderer&) { return ticket_.done(); });
  }
  nb::object take() {
    if (views_.worlds()) views_.invalid = renderer_->use([&](Renderer&) { return ticket_.invalidWorlds(); });
    if (onDevice_ || formatted_) {
      std::vector<float> exposures;
      std::map<std::string, DeviceArray> arrays = renderer_->use([&](Renderer&) {
        exposures = ticket_.exposures();
        return ticket_.takeArrays();
      });
      kept_.reset();
      return onDevice_ ? deviceFramesOf(std::move(arrays), views_, exposures)
                       : formattedFramesOf(arrays, views_, exposures);
    }
    return framesOf(renderer_->use([&](Renderer&) { return ticket_.take(); }), views_);
  }

 private:
  std::shared_ptr<SharedRenderer> renderer_;
  Ticket ticket_;
  Views views_;
  bool onDevice_, formatted_;
  std::unique_ptr<GivenWorlds> kept_;
};

// --- the class ------------------------------------------------------------------------------------------------------

void makeRenderer(SharedRenderer* self, nb::handle scene, nb::handle device, nb::handle environment) {
  std::shared_ptr<SharedScene> shared;
  if (!nb::try_cast(scene, shared, false) || !shared) badType("scene must be a Scene, not {}", typeName(scene));
  const std::string name =
      PyLong_Check(device.ptr()) ? std::to_string(integerOf(device, "device", 0, INT32_MAX)) : textOf(device, "device");
  std::function<std::unique_ptr<Renderer>(const Scene&)> make;
  const bool named = environment.is_none() || PyUnicode_Check(environment.ptr()) ||
                     PyObject_HasAttrString(environment.ptr(), "__fspath__");
  if (named) {
    const std::string path = environment.is_none() ? "" : pathOf(environment, "environment");
    make = [=](const Scene& scene) { return std::make_unique<Renderer>(scene, name, path); };
  } else {
    make = [=, data = environmentOf(environment)](const Scene& scene) {
      return std::make_unique<Renderer>(scene, name, data);
    };
  }
  new (self) SharedRenderer(shared, shared->read(make));
}

// Removes the arguments that state where results are left from `keywords`.
Destination destinationOf(nb::dict& keywords) {
  Destination to;
  to.onDevice = boolOf(keywords.attr("pop")("on_device", false), "on_device");
  const nb::object formats = keywords.attr("get")("formats"), order = keywords.attr("get")("channels_first");
  to.formatted = !formats.is_none() || (!order.is_none() && boolOf(order, "channels_first"));
  to.targets = targetsOf(keywords.attr("pop")("out", nb::none()));
  if (!to.targets.empty() && !to.onDevice) badValue("out requires on_device=True");
  to.results = to.onDevice || to.formatted ? Results::Arrays : Results::ToHost;
  return to;
}

std::shared_ptr<SharedTicket> submit(const std::shared_ptr<SharedRenderer>& renderer, nb::handle cameras,
                                     nb::handle size, nb::handle outputs, const nb::kwargs& keywords) {
  nb::dict optional;
  optional.update(keywords);
  const Destination to = destinationOf(optional);
  const Camera* one = nullptr;
  const bool single = nb::try_cast<const Camera*>(cameras, one, false) && one;
  const std::vector<Camera> views = camerasOf(cameras, "cameras");
  if (views.empty()) badValue("cameras must have at least one");
  const Options options = optionsOf(size, outputs, optional);
  Ticket ticket =
      renderer->use([&](Renderer& renderer) { return renderer.submit(views, options, to.results, to.targets); });
  Views shape{single ? std::vector<size_t>{} : std::vector{views.size()}, {}};
  return std::make_shared<SharedTicket>(renderer, std::move(ticket), std::move(shape), to);
}

nb::object render(const std::shared_ptr<SharedRenderer>& renderer, nb::handle cameras, nb::handle size,
                  nb::handle outputs, const nb::kwargs& keywords) {
  return submit(renderer, cameras, size, outputs, keywords)->take();
}

std::shared_ptr<SharedTicket> submitWorlds(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count,
                                           nb::handle cameras, nb::handle size, nb::handle outputs,
                                           const nb::kwargs& keywords) {
  nb::dict optional;
  optional.update(keywords);
  const Destination to = destinationOf(optional);
  WorldCall call = worldCall(renderer, count, cameras, optional);
  const Options options = optionsOf(size, outputs, optional);
  Ticket ticket = renderer->use(
      [&](Renderer& r) { return r.submit(completed(call, *renderer, r), options, to.results, to.targets); });
  const Worlds& worlds = call.given->worlds;
  Views views{{worlds.count, worlds.cameras.size()}, {}};
  return std::make_shared<SharedTicket>(renderer, std::move(ticket), std::move(views), to, std::move(call.given));
}

nb::object renderWorlds(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count, nb::handle cameras,
                        nb::handle size, nb::handle outputs, const nb::kwargs& keywords) {
  return submitWorlds(renderer, count, cameras, size, outputs, keywords)->take();
}

std::vector<Pick> pick(const std::shared_ptr<SharedRenderer>& renderer, nb::handle camera, nb::handle pixels,
                       nb::handle size, const nb::kwargs& keywords) {
  const Camera view = objectOf<Camera>(camera, "camera", "a Camera");
  const nb::object array = arrayOf(rowsWithColumns(pixels, 2), "pixels", Elements::Integers, {-1, 2}, "int64");
  const Options options = optionsOf(size, nb::make_tuple("rgba"), keywords);
  std::vector<std::array<uint32_t, 2>> places(lengthOf(array, 0));
  if (places.empty()) return {};
  const int64_t* numbers = viewOf<int64_t>(array).data();
  for (size_t i = 0; i < places.size(); ++i) {
    const int64_t x = numbers[2 * i], y = numbers[2 * i + 1];
    if (x < 0 || y < 0 || x >= options.width || y >= options.height)
      badValue("pixels must lie in the picture of {}x{} pixels, and one is at {}, {}", options.width, options.height, x,
               y);
    places[i] = {static_cast<uint32_t>(x), static_cast<uint32_t>(y)};
  }
  return renderer->use([&](Renderer& renderer) { return renderer.pick(view, places, options); });
}

// Calls `work` with the renderer and the options of a picture without outputs.
template <typename Work>
auto label(const std::shared_ptr<SharedRenderer>& renderer, nb::handle size, const nb::kwargs& keywords, Work work) {
  const Options options = optionsOf(size, nb::make_tuple("rgba"), keywords);
  return renderer->use([&](Renderer& renderer) { return work(renderer, options); });
}

nb::object labels(const std::shared_ptr<SharedRenderer>& renderer, nb::handle camera, nb::handle size,
                  const nb::kwargs& keywords) {
  const Camera view = objectOf<Camera>(camera, "camera", "a Camera");
  return labelsOf(label(renderer, size, keywords,
                        [&](Renderer& renderer, const Options& options) { return renderer.labels(view, options); }));
}

nb::object keypoints(const std::shared_ptr<SharedRenderer>& renderer, nb::handle camera, nb::handle points,
                     nb::handle size, const nb::kwargs& keywords) {
  const Camera view = objectOf<Camera>(camera, "camera", "a Camera");
  const std::vector<Keypoint> keypoints = keypointsOf(points, "keypoints");
  return keypointLabelsOf(keypoints, label(renderer, size, keywords, [&](Renderer& renderer, const Options& options) {
                            return renderer.keypoints(view, keypoints, options);
                          }));
}

// Calls `work` with the renderer, the worlds and the options of images without outputs.
template <typename Work>
auto labelWorlds(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count, nb::handle cameras, nb::handle size,
                 const nb::kwargs& keywords, Work work) {
  nb::dict optional;
  optional.update(keywords);
  WorldCall call = worldCall(renderer, count, cameras, optional);
  const Options options = optionsOf(size, nb::make_tuple("rgba"), optional);
  return renderer->use([&](Renderer& r) { return work(r, completed(call, *renderer, r), options); });
}

nb::object labelsOfWorlds(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count, nb::handle cameras,
                          nb::handle size, const nb::kwargs& keywords) {
  size_t each = 0;
  std::vector<Labels> labels = labelWorlds(renderer, count, cameras, size, keywords,
                                           [&](Renderer& r, const Worlds& worlds, const Options& options) {
                                             each = worlds.cameras.size();
                                             return r.labels(worlds, options);
                                           });
  return worldLabelsOf(std::move(labels), each);
}

nb::object keypointsOfWorlds(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count, nb::handle cameras,
                             nb::handle points, nb::handle size, const nb::kwargs& keywords) {
  const std::vector<Keypoint> keypoints = keypointsOf(points, "keypoints");
  size_t each = 0;
  const auto labels = labelWorlds(renderer, count, cameras, size, keywords,
                                  [&](Renderer& r, const Worlds& worlds, const Options& options) {
                                    each = worlds.cameras.size();
                                    return r.keypoints(worlds, keypoints, options);
                                  });
  return worldKeypointLabelsOf(keypoints, labels, each);
}

nb::object correspondWorlds(const std::shared_ptr<SharedRenderer>& renderer, nb::handle count, nb::handle cameras,
                            nb::handle size, const nb::kwargs& keywords) {
  size_t each = 0;
  std::vector<Correspondence> views = labelWorlds(renderer, count, cameras, size, keywords,
                                                  [&](Renderer& r, const Worlds& worlds, const Options& options) {
                                                    each = worlds.cameras.size();
                                                    return r.correspond(worlds, options);
                                                  });
  return worldCorrespondenceOf(std::move(views), each);
}

nb::object correspond(const std::shared_ptr<SharedRenderer>& renderer, nb::handle first, nb::handle second,
                      nb::handle size, nb::handle secondTime, const nb::kwargs& keywords) {
  const Camera from = objectOf<Camera>(first, "first", "a Camera"), to = objectOf<Camera>(second, "second", "a Camera");
  std::optional<double> time;
  if (!secondTime.is_none()) time = numberOf(secondTime, "second_time");
  return correspondenceOf(label(renderer, size, keywords, [&](Renderer& renderer, const Options& options) {
    return renderer.correspond(from, to, options, time);
  }));
}

nb::dict scanLidar(nb::handle of, nb::handle pattern, nb::handle poses, nb::handle samples, nb::handle returns,
                   nb::handle seed, nb::handle slices, const nb::kwargs& keywords) {
  std::shared_ptr<SharedRenderer> renderer;
  // An argument of the pointer's type would be null for None.
  if (!nb::try_cast(of, renderer, false) || !renderer) badType("renderer must be a Renderer, not {}", typeName(of));
  const LidarPattern firings = patternOf(pattern);
  const std::vector<double> values = doublesOf(poses, "poses", {-1, 4, 4});
  std::vector<Transform> matrices(values.size() / 16);
  if (!matrices.empty()) std::memcpy(matrices.data(), values.data(), sizeof(double) * values.size());
  constexpr int64_t kMaxSamples = 1024, kMaxSlices = 100'000;  // those of LidarOptions
  LidarOptions lidar{.samples = static_cast<uint32_t>(integerOf(samples, "samples", 1, kMaxSamples)),
                     .returns = textOf(returns, "returns"),
                     .seed = std::nullopt,
                     .slices = static_cast<uint32_t>(integerOf(slices, "slices", 1, kMaxSlices))};
  if (!seed.is_none()) lidar.seed = static_cast<uint64_t>(integerOf(seed, "seed", 0, INT64_MAX));
  const Options options = optionsOf(nb::none(), nb::make_tuple("rgba"), keywords);
  return pointsOf(renderer->use([&](Renderer& renderer) { return renderer.scan(firings, matrices, lidar, options); }));
}

void bindPick(nb::module_& module) {
  nb::class_<Pick>(module, "Pick", "What a pixel shows, at its center.")
      .def_ro("id", &Pick::id, "as in the output \"id\"; 0: background, and nothing else is set")
      .def_ro("part", &Pick::part, "as in the output \"part\"")
      .def_ro("node", &Pick::node)
      .def_ro("mesh", &Pick::mesh)
      .def_ro("material", &Pick::material)
      .def_ro("primitive", &Pick::primitive, "of the mesh")
      .def_prop_ro(
          "position", [](const Pick& p) { return tupleOf(p.position); },
          nb::sig("def position(self) -> tuple[float, ...]"))
      .def_prop_ro(
          "normal", [](const Pick& p) { return tupleOf(p.normal); }, nb::sig("def normal(self) -> tuple[float, ...]"))
      .def_prop_ro(
          "geonormal", [](const Pick& p) { return tupleOf(p.geonormal); },
          nb::sig("def geonormal(self) -> tuple[float, ...]"))
      .def_ro("depth", &Pick::depth, "meters")
      .def_ro("distance", &Pick::distance, "meters")
      .def_prop_ro(
          "uv", [](const Pick& p) { return tupleOf(p.uv); }, nb::sig("def uv(self) -> tuple[float, ...]"));
}

std::string signatureOf(const char* name, const char* cameras, const char* onDevice, const char* result) {
  return fmt::format(
      "def {}(self, cameras: {}, size: tuple[int, int] = (1280, 720), outputs: str | collections.abc.Sequence[str] = "
      "(\"rgba\",), *, on_device: {}, out: latelight.frames.DeviceFrames | None = None{}) -> {}",
      name, cameras, onDevice, optionParameters(), result);
}

constexpr const char* kMany = "collections.abc.Sequence[Camera]";
void defineRender(nb::class_<SharedRenderer>& type) {
  const std::string docs =
      "\n\ncameras: one, or a list, which is rendered together where memory allows\n"
      "size: width and height in pixels\noutputs: any of:\n" +
      outputDocs() +
      "\non_device: leave them in the device's memory, for torch, CuPy and JAX (DeviceFrames)\nout: what an earlier "
      "call of this renderer with on_device returned, for the same outputs\nand sizes, one array per output: render "
      "into its memory again" +
      "\n\nOptions:\n" + optionDocs();
  const std::string any = "Camera | " + std::string(kMany);
  const std::string one = signatureOf("render", "Camera", "typing.Literal[False] = False", "latelight.frames.Frame");
  const std::string many = signatureOf("render", kMany, "typing.Literal[False] = False", "latelight.frames.Frames");
  const std::string there = signatureOf("render", any.c_str(), "typing.Literal[True]", "latelight.frames.DeviceFrames");
  const std::string later = signatureOf("submit", any.c_str(), "bool = False", "Ticket");
  const std::string rendered =
      "Pictures of the scene, as arrays: a Frame for a camera, Frames for a list, and DeviceFrames with on_device." +
      docs;
  const std::string submitted =
      "The same as render(), and returns while the device works; up to three tickets keep it busy." + docs;
  const auto size = nb::make_tuple(1280, 720);
  const auto outputs = nb::make_tuple("rgba");
  // Overloads with other result types, for type checkers. At run time the first one accepts all calls.
  type.def("render", &render, argument("cameras"), argument("size") = size, argument("outputs") = outputs,
           nb::arg("options"), nb::sig(one.c_str()), rendered.c_str());
  type.def("render", &render, argument("cameras"), argument("size") = size, argument("outputs") = outputs,
           nb::arg("options"), nb::sig(many.c_str()));
  type.def("render", &render, argument("cameras"), argument("size") = size, argument("outputs") = outputs,
           nb::arg("options"), nb::sig(there.c_str()));
  type.def("submit", &submit, argument("cameras"), argument("size") = size, argument("outputs") = outputs,
           nb::arg("options"), nb::sig(later.c_str()), submitted.c_str());
}

void defineWorlds(nb::class_<SharedRenderer>& type) {
  const auto signature = [](const char* name, const char* onDevice, const char* result) {
    return fmt::format(
        "def {}(self, count: int, cameras: Camera | {}, size: tuple[int, int] = (1280, 720), outputs: str | "
        "collections.abc.Sequence[str] = (\"rgba\",), *{}, on_device: {}, out: latelight.frames.DeviceWorldFrames | "
        "None = None, stream: typing.Any | None = None{}) -> {}",
        name, kMany, worldParameters(), onDevice, optionParameters({"environment_rotation", "environment_intensity"}),
        result);
  };
  const std::string docs =
      "\n\ncount: the number N of worlds\ncameras: the C cameras of each world" + worldDocs() +
      "\nsize, outputs, on_device, out and options: as those of render()\nstream: the CUDA stream "
      "whose work precedes the call (a number, or a stream of torch, CuPy or Warp); default: what\n"
      "each array's library reports";
  const std::string rendered =
      "Images of N worlds: the scene in N states. All worlds share what no argument states. Arrays have the "
      "shape\n(N, C, H, W) or (N, C, H, W, channels)." +
      docs;
  const std::string submitted = "The same as render_worlds(), and returns while the device works." + docs;
  const std::string here = signature("render_worlds", "typing.Literal[False] = False", "latelight.frames.WorldFrames");
  const std::string there = signature("render_worlds", "typing.Literal[True]", "latelight.frames.DeviceWorldFrames");
  const std::string later = signature("submit_worlds", "bool = False", "Ticket");
  const auto size = nb::make_tuple(1280, 720);
  const auto outputs = nb::make_tuple("rgba");
  type.def("render_worlds", &renderWorlds, argument("count"), argument("cameras"), argument("size") = size,
           argument("outputs") = outputs, nb::arg("options"), nb::sig(here.c_str()), rendered.c_str());
  type.def("render_worlds", &renderWorlds, argument("count"), argument("cameras"), argument("size") = size,
           argument("outputs") = outputs, nb::arg("options"), nb::sig(there.c_str()));
  type.def("submit_worlds", &submitWorlds, argument("count"), argument("cameras"), argument("size") = size,
           argument("outputs") = outputs, nb::arg("options"), nb::sig(later.c_str()), submitted.c_str());
}

void defineLabels(nb::class_<SharedRenderer>& type) {
  const auto size = nb::make_tuple(1280, 720);
  const std::string picture = "size: tuple[int, int] = (1280, 720), *";
  const std::string labelsSignature =
      "def labels(self, camera: Camera, " + picture + optionParameters() + ") -> latelight.labels.Labels";
  type.def("labels", &labels, argument("camera"), argument("size") = size, nb::arg("options"),
           nb::sig(labelsSignature.c_str()),
           "The objects of such a picture, with visible and amodal masks, boxes and occlusions, as arrays "
           "(latelight.labels.Labels).\nEach object is rendered once by itself; nothing is lit.");
  const std::string keypointsSignature =
      "def keypoints(self, camera: Camera, keypoints: collections.abc.Sequence[latelight.labels.Keypoint | str], " +
      picture + optionParameters() + ") -> latelight.labels.Keypoints";
  type.def("keypoints", &keypoints, argument("camera"), argument("keypoints"), argument("size") = size,
           nb::arg("options"), nb::sig(keypointsSignature.c_str()),
           "Projects points that follow nodes to such a picture, with COCO's visibility. keypoints: Keypoint objects, "
           "or paths\nof nodes. Raises UsageError if the scene has no such node.");
  const std::string views = "self, count: int, cameras: Camera | " + std::string(kMany) + ", ";
  const std::string worlds = picture + worldParameters() + ", stream: typing.Any | None = None" +
                             optionParameters({"environment_rotation", "environment_intensity"}) +
                             ") -> latelight.labels.";
  const std::string worldLabelsSignature = "def labels_of_worlds(" + views + worlds + "WorldLabels";
  type.def("labels_of_worlds", &labelsOfWorlds, argument("count"), argument("cameras"), argument("size") = size,
           nb::arg("options"), nb::sig(worldLabelsSignature.c_str()),
           "The objects of the images of worlds, as labels() returns them for one, with arrays (N, C, ...). The "
           "arguments are those\nof render_worlds().");
  const std::string worldKeypointsSignature = "def keypoints_of_worlds(" + views +
                                              "keypoints: collections.abc.Sequence[latelight.labels.Keypoint | str], " +
                                              worlds + "WorldKeypoints";
  type.def("keypoints_of_worlds", &keypointsOfWorlds, argument("count"), argument("cameras"), argument("keypoints"),
           argument("size") = size, nb::arg("options"), nb::sig(worldKeypointsSignature.c_str()),
           "Keypoints in the images of worlds, as keypoints() returns them for one, with arrays (N, C, K, ...). The "
           "other arguments\nare those of render_worlds().");
  const std::string worldCorrespondSignature = "def correspond_worlds(" + views + worlds + "WorldCorrespondence";
  type.def("correspond_worlds", &correspondWorlds, argument("count"), argument("cameras"), argument("size") = size,
           nb::arg("options"), nb::sig(worldCorrespondSignature.c_str()),
           "Finds the surfaces of the images of worlds in those of the next frame, as correspond() does for one, with "
           "arrays\n(N, C, ...). The arguments are those of render_worlds(), of which next_transforms, "
           "next_camera_to_world and so on\ndescribe the next frame.");
  const std::string correspondSignature =
      "def correspond(self, first: Camera, second: Camera, size: tuple[int, int] = (1280, 720), "
      "second_time: float | None = None, *" +
      optionParameters() + ") -> latelight.labels.Correspondence";
  type.def("correspond", &correspond, argument("first"), argument("second"), argument("size") = size,
           argument("second_time") = nb::none(), nb::arg("options"), nb::sig(correspondSignature.c_str()),
           "Finds the surfaces of the first camera's picture in the second camera's: pixels, visibility and scene "
           "flow.\nBoth pictures have this size. second_time: the time in the animation that the second shows, in "
           "seconds; None: the\noption time, as the first.");
}

}  // namespace

void bindRenderer(nb::module_& module) {
  bindPick(module);
  nb::class_<SharedTicket>(module, "Ticket", nb::is_weak_referenceable(),
                           "Pictures in flight, as returned by Renderer.submit().")
      .def_prop_ro("done", &SharedTicket::done, "take() would not wait for the device")
      .def("take", &SharedTicket::take,
           nb::sig(
               "def take(self) -> latelight.frames.Frame | latelight.frames.Frames | latelight.frames.DeviceFrames | "
               "latelight.frames.WorldFrames"),
           "Waits for the pictures and returns them; a second call fails. A Frame for a camera, Frames for a list, "
           "WorldFrames for "
           "worlds. Errors of the work are\nraised here.");
  bindCastTicket(module);
  nb::class_<SharedRenderer> type(
      module, "Renderer", nb::is_weak_referenceable(),
      "One scene on one device; keeps its pipelines and buffers from one call to the next.\n\n"
      "Any thread may call it, one at a time; Python's other threads run meanwhile. It belongs to the process that\n"
      "created it: in a forked process each call raises UsageError, and a new renderer of its scene works.");
  type.def(
      "__init__", &makeRenderer, argument("scene"), argument("device") = "auto", argument("environment") = nb::none(),
      nb::sig("def __init__(self, scene: Scene, device: str | int = \"auto\", "
              "environment: str | os.PathLike[str] | numpy.typing.NDArray[typing.Any] | None = None) -> None"),
      "device: \"auto\", \"cpu\", \"cuda:0\" (as torch numbers GPUs), an index, a part of a name or a "
      "UUID\nenvironment: a .hdr or .exr file, \"studio\", "
      "\"none\", or linear radiance as an array (H, 2 H, 3), center column at +X of\nthe glTF frame and top row at the "
      "zenith; None: the studio where the scene has no light\n\nRaises NoDeviceError where there is no such device.");
  type.def_prop_ro("scene", [](const SharedRenderer& r) { return r.scene(); });
  type.def_prop_ro(
      "device", [](SharedRenderer& r) { return r.use([](Renderer& r) { return r.deviceName(); }); },
      "The device's name.");
  type.def_prop_ro("copied_bytes", &SharedRenderer::copiedBytes,
                   "Bytes of arrays in CUDA's memory that were copied on the device so far, without the host.");
  type.def(
      "validation_messages",
      [](SharedRenderer& r) { return r.use([](Renderer& r) { return r.validationMessages(); }); },
      "Messages of Vulkan's validation layers since the last call. LATELIGHT_VALIDATION=1 enables the layers.");
  type.def(
      "finish", [](SharedRenderer& r) { r.use([](Renderer& r) { r.finish(); }); },
      "Waits until the device has finished everything that was submitted.");
  defineRender(type);
  defineWorlds(type);
  defineWorldRays(type);
  defineLabels(type);
  const std::string signature =
      "def pick(self, camera: Camera, pixels: numpy.typing.ArrayLike, size: tuple[int, int] = (1280, 720), *" +
      optionParameters() + ") -> list[Pick]";
  type.def("pick", &pick, argument("camera"), argument("pixels"), argument("size") = nb::make_tuple(1280, 720),
           nb::arg("options"), nb::sig(signature.c_str()),
           "What pixels (N, 2), x and y from the upper left, of such a picture show, in their order. Lights nothing.");
  defineRays(type);
  const std::string scanSignature =
      "def scan_lidar(renderer: Renderer, pattern: latelight.lidar.Pattern, poses: numpy.typing.ArrayLike, samples: "
      "int, returns: str, seed: int | None, slices: int, *" +
      optionParameters({"samples"}) + ") -> dict[str, numpy.typing.NDArray[typing.Any]]";
  module.def("scan_lidar", &scanLidar, argument("renderer"), argument("pattern"), argument("poses"),
             argument("samples"), argument("returns"), argument("seed"), argument("slices"), nb::arg("options"),
             nb::sig(scanSignature.c_str()), "The fields of latelight.lidar.Scan.");
}

}  // namespace latelight::python
