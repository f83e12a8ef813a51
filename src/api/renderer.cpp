// The renderer of the public API: pictures of cameras and of worlds, their tickets, and picks.
#include "api/renderer.h"

#include <algorithm>
#include <cstdint>
#include <new>
#include <utility>

#include "api/device_array.h"
#include "api/settings.h"
#include "base/error.h"
#include "base/log.h"
#include "base/memory.h"
#include "render/submit/picking.h"
#include "render/submit/session.h"

namespace latelight {

namespace {

render::Results internalResults(Results results) {
  switch (results) {
    case Results::OnDevice:
      return render::Results::OnDevice;
    case Results::Arrays:
      return render::Results::Exported;
    case Results::ToHost:
      return render::Results::ToHost;
  }
  badUsage("there are no results {}: choose one of Results", static_cast<int>(results));
}

Frame publicFrame(output::FrameOutput&& from) {
  Frame frame;
  frame.width = from.width;
  frame.height = from.height;
  frame.rgba = std::move(from.display);
  frame.exposure = from.exposure;
  for (output::AovImage& image : from.aovs) {
    const output::AovInfo& info = output::info(image.aov);
    frame.aovs[std::string(info.name)] = {info.channels, std::move(image.values), std::move(image.ids)};
  }
  return frame;
}

}  // namespace

Renderer::Renderer(const Scene& scene, const std::string& device, const EnvironmentData& environment) try
    : impl_(ownedByProcess(new Impl(scene.filled(), device, makeEnvironment(environment)))) {
} catch (const std::bad_alloc&) {
  failWithoutMemory("the renderer");
}
Renderer::Renderer(const Scene& scene, const std::string& device, const std::string& environment) try
    : impl_(ownedByProcess(
          new Impl(scene.filled(), device,
                   render::loadEnvironment(scene.filled().scene,
                                           render::environmentName(scene.filled().scene, environment, false))))) {
} catch (const std::bad_alloc&) {
  failWithoutMemory("the renderer");
}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

namespace {

// Marks this thread as one that is in the callback of whileWaiting() for a device. Such a callback may call another
// renderer, whose callback this thread then is in, too.
class CallbackScope {
 public:
  explicit CallbackScope(const vk::Device* device) : device_(device), outer_(std::exchange(innermost_, this)) {}
  ~CallbackScope() { innermost_ = outer_; }
  CallbackScope(const CallbackScope&) = delete;
  CallbackScope& operator=(const CallbackScope&) = delete;

  static bool contains(const vk::Device& device) {
    const CallbackScope* scope = innermost_;
    while (scope && scope->device_ != &device) scope = scope->outer_;
    return scope != nullptr;
  }

 private:
  static thread_local const CallbackScope* innermost_;
  const vk::Device* device_;
  const CallbackScope* outer_;
};

thread_local const CallbackScope* CallbackScope::innermost_ = nullptr;

}  // namespace

void requireIdle(const vk::Device& device) {
  if (CallbackScope::contains(device))
    badUsage("the renderer is in use: a signal handler or callback that runs while it waits must not call it");
}

Renderer::Impl& Renderer::filled() const {
  if (!impl_) badUsage("this renderer has been moved to another object: use that one");
  return usable(impl_);
}

const std::string& Renderer::deviceName() const {
  return filled().device->info().name;
}

const std::string& Renderer::deviceUuid() const {
  return filled().device->info().uuid;
}

std::vector<std::string> Renderer::validationMessages() {
  return filled().device->validationMessages();
}

void Renderer::whileWaiting(std::function<void()> check) {
  // The callback may replace itself, but not call anything else.
  const bool inCallback = impl_ && impl_->owner.isThis() && CallbackScope::contains(*impl_->device);
  Impl& impl = inCallback ? *impl_ : filled();
  if (!check) return impl.device->whileWaiting({});
  const vk::Device* const device = impl.device.get();
  impl.device->whileWaiting([device, check = std::move(check), interrupted = impl.interrupted] {
    const CallbackScope scope(device);
    try {
      check();
    } catch (...) {
      *interrupted = true;
      throw;
    }
  });
}

void Renderer::finish() {
  filled().device->finish();
}

Frame Renderer::render(const Camera& camera, const Options& options) try {
  return std::move(render(std::vector<Camera>{camera}, options).front());
} catch (const std::bad_alloc&) {
  failWithoutMemory("the picture of the camera");
}

std::vector<Frame> Renderer::render(const std::vector<Camera>& cameras, const Options& options) try {
  return submit(cameras, options).take();
} catch (const std::bad_alloc&) {
  failWithoutMemory("the pictures of the cameras");
}

struct Ticket::Impl {
  static constexpr const char* kResults = "pictures";
  std::shared_ptr<Renderer::Impl> renderer;
  render::Ticket ticket;
  Results results;
  std::vector<uint32_t> invalidWorlds{};
  bool awaitsWorlds = false;  // the device reports invalid worlds
  MemoryClaim memory{};       // of the cameras

  // Waits for the report.
  void checkWorlds() {
    if (!awaitsWorlds) return;
    const std::vector<uint32_t> status = ticket.worldStatus();
    invalidWorlds = worldsOfStatus(status);
    awaitsWorlds = false;
    warnOfInvalidWorlds(invalidWorlds, status.size());
  }
};

Ticket::Ticket() = default;
Ticket::~Ticket() = default;
Ticket::Ticket(Ticket&&) noexcept = default;
Ticket& Ticket::operator=(Ticket&&) noexcept = default;

bool Ticket::done() const {
  return !impl_ || !impl_->renderer || (usable(impl_->renderer), impl_->ticket.done());
}

std::vector<float> Ticket::exposures() const try {
  requireUntaken(impl_);
  const std::shared_ptr<Impl> impl = impl_;  // the callback of whileWaiting() may destroy this object
  return impl->ticket.exposures();
} catch (const std::bad_alloc&) {
  failWithoutMemory(Impl::kResults);
}

std::vector<Frame> Ticket::take() try {
  requireUntaken(impl_);
  if (impl_->results == Results::Arrays) badUsage("these pictures are arrays on the device: take those");
  std::vector<output::FrameOutput> from = taken(impl_, [](Impl& ticket) {
    ticket.checkWorlds();
    return ticket.ticket.take().frames;
  });
  std::vector<Frame> frames;
  for (output::FrameOutput& frame : from) frames.push_back(publicFrame(std::move(frame)));
  return frames;
} catch (const std::bad_alloc&) {
  failWithoutMemory(Impl::kResults);
}

std::map<std::string, DeviceArray> Ticket::takeArrays() try {
  requireUntaken(impl_);
  if (impl_->results != Results::Arrays) badUsage("these pictures are no arrays: submit them with Results::Arrays");
  const std::shared_ptr<vk::Device> device = impl_->renderer->device;
  std::vector<render::ExportedArray> results = taken(impl_, [](Impl& ticket) {
    ticket.checkWorlds();
    return ticket.ticket.take().arrays;
  });
  std::map<std::string, DeviceArray> arrays;
  for (render::ExportedArray& from : results) {
    DeviceArray& array = arrays[from.aov ? std::string(output::info(*from.aov).name) : "rgba"];
    using enum DeviceArray::Element;
    const bool integers = from.aov && output::holdsIntegers(*from.aov), shorter = from.elementBytes == 2;
    array.element = !from.aov ? Uint8 : integers ? (shorter ? Uint16 : Uint32) : shorter ? Float16 : Float32;
    array.shape = {from.views, from.rows, from.columns, from.channels};
    array.channelsFirst = from.channelsFirst;
    if (from.channelsFirst) array.shape = {from.views, from.channels, from.rows, from.columns};
    array.impl_ =
        ownedByProcess(new DeviceArray::Impl{.owner = {}, .device = device, .memory = std::move(from.memory)});
  }
  return arrays;
} catch (const std::bad_alloc&) {
  failWithoutMemory(Impl::kResults);
}

namespace {

// Throws Error(Usage) unless the output of this name is requested and `views` images of it fit into the array. Its
// memory may be larger than the array.
void checkTarget(const std::string& name, const DeviceArray& array, const render::Settings& settings, uint64_t views) {
  const render::ExportFormats& formats = settings.exports;
  uint64_t pixelBytes = formats.rgb ? 3 : 4;
  if (name != "rgba" || !settings.display) {
    const auto aov = std::ranges::find(settings.aovs, name, [](output::Aov each) { return output::info(each).name; });
    if (aov == settings.aovs.end())
      badUsage("there is an array to render {} into, but this output is not requested", printable(name));
    pixelBytes = uint64_t{output::info(*aov).channels} * (std::ranges::count(formats.shorter, *aov) > 0 ? 2 : 4);
  }
  if (!DeviceArrayMemory::contains(array, 0, views * settings.width * settings.height, pixelBytes))
    badUsage("the array to render {} into is smaller than the output: use one of a call with the same size and formats",
             name);
}

// Whoever reads the arrays must have finished. `ordered`: the device waits for them.
render::ExportTargets targetsOf(const std::map<std::string, DeviceArray>& arrays, const vk::Device& device,
                                const render::Settings& settings, uint64_t views, Results results, bool ordered) {
  if (!arrays.empty() && results != Results::Arrays) badUsage("only Results::Arrays are rendered into given arrays");
  render::ExportTargets targets = DeviceArrayMemory::targets(arrays, device);
  for (const auto& [name, array] : arrays) checkTarget(name, array, settings, views);
  for (const auto& [aov, memory] : targets)
    if (!ordered && memory->beforeReuse) memory->beforeReuse();
  return targets;
}

void checkFormats(const Options& options, Results results) {
  if ((!options.formats.empty() || options.channelsFirst) && results != Results::Arrays)
    badUsage("formats and the order of channels apply to Results::Arrays only");
}

}  // namespace

Ticket Renderer::submit(const std::vector<Camera>& cameras, const Options& options, Results results,
                        const std::map<std::string, DeviceArray>& targets) try {
  filled();
  checkFormats(options, results);
  if (cameras.empty()) badUsage("nothing can be rendered without a camera");
  const render::Settings settings = settingsFor(*impl_->device, options, impl_->scene);
  MemoryClaim memory = claimCameras(cameras.size() + options.previousCameras.size() + options.nextCameras.size());
  const std::vector<scene::Camera> internal =
      internalCameras(cameras, impl_->scene, cameras.size(), settings.cameraFit);
  render::SceneState moment = internalState(options, settings, impl_->scene, cameras.size());
  setExposures(moment, cameras, settings);
  Ticket ticket;
  ticket.impl_ = ownedByProcess(new Ticket::Impl{
      impl_,
      impl_->renderer.submit(internal, settings, moment, internalResults(results),
                             targetsOf(targets, *impl_->device, settings, cameras.size(), results, false)),
      results,
      {},
      false,
      std::move(memory)});
  return ticket;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the pictures of the cameras");
}

std::vector<Frame> Renderer::render(const Worlds& worlds, const Options& options) try {
  return submit(worlds, options).take();
} catch (const std::bad_alloc&) {
  failWithoutMemory("the pictures of the worlds");
}

std::vector<const scene::Environment*> Renderer::Impl::environmentsOf(const std::vector<std::string>& names) {
  std::vector<const scene::Environment*> found;
  for (const std::string& name : names) {
    if (name.empty() || name == "none") badUsage("the environments of worlds must be .hdr or .exr files, or studio");
    auto known = environments.find(name);
    if (known == environments.end()) known = environments.emplace(name, *render::loadEnvironment(scene, name)).first;
    found.push_back(&known->second);
  }
  return found;
}

Ticket Renderer::submit(const Worlds& worlds, const Options& options, Results results,
                        const std::map<std::string, DeviceArray>& targets) try {
  filled();
  checkFormats(options, results);
  if (!options.previousCameras.empty() || !options.nextCameras.empty())
    badUsage("worlds have previous and next cameras of their own: leave those of the options empty");
  rejectExposures(worlds.cameras);
  const render::Settings settings = settingsFor(*impl_->device, options, impl_->scene, rasterUseOf(worlds));
  render::SceneState moment = internalState(options, settings, impl_->scene, 0);
  if (worlds.arrays.ready > 0 && impl_->inputTimeline)
    impl_->device->waitFirst(impl_->inputTimeline->get(), worlds.arrays.ready);
  moment.worlds.environments = impl_->environmentsOf(worlds.environments);
  WorldCameras internal = impl_->source.convert(worlds, settings, moment, impl_->renderer, *impl_->device);
  // If shaders place the worlds, the cameras are those of each world.
  const uint64_t views = internal.cameras.size() * (moment.worlds.inputs ? uint64_t{worlds.count} : 1);
  Ticket ticket;
  ticket.impl_ = ownedByProcess(new Ticket::Impl{
      impl_,
      impl_->renderer.submit(internal.cameras, settings, moment, internalResults(results),
                             targetsOf(targets, *impl_->device, settings, views, results, worlds.arrays.ready > 0)),
      results, std::move(internal.invalid), internal.onDevice, std::move(internal.memory)});
  return ticket;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the pictures of the worlds");
}

std::shared_ptr<const DeviceArray> Renderer::inputArray(uint64_t bytes) try {
  vk::Device& device = *filled().device;
  auto array = std::make_shared<DeviceArray>();
  array->element = DeviceArray::Element::Uint8;
  array->shape = {1, 1, 1, bytes};
  const uint64_t padded = (std::min(bytes, ~uint64_t{0} - 15) + 15) / 16 * 16;
  array->impl_ = ownedByProcess(
      new DeviceArray::Impl{.owner = {}, .device = impl_->device, .memory = impl_->inputs->take(device, padded)});
  return array;
} catch (const std::bad_alloc&) {
  failWithoutMemory("an array");
}

int Renderer::exportInputSemaphore() {
  Impl& impl = filled();
  if (!impl.inputTimeline) impl.inputTimeline.emplace(*impl.device);
  return impl.inputTimeline->exportSemaphore();
}

const std::vector<uint32_t>& Ticket::invalidWorlds() const try {
  requireUntaken(impl_);
  const std::shared_ptr<Impl> impl = impl_;  // the callback of whileWaiting() may destroy this object
  impl->checkWorlds();
  return impl->invalidWorlds;
} catch (const std::bad_alloc&) {
  failWithoutMemory(Impl::kResults);
}

std::vector<Pick> Renderer::pick(const Camera& camera, const std::vector<std::array<uint32_t, 2>>& pixels,
                                 const Options& options) try {
  Impl& impl = filled();
  const render::Settings settings = withExposure(settingsFor(*impl.device, options, impl.scene), camera);
  std::vector<glm::uvec2> places;
  for (const auto& [x, y] : pixels) places.push_back({x, y});
  const auto three = [](glm::vec3 v) { return std::array<float, 3>{v.x, v.y, v.z}; };
  std::vector<Pick> picks;
  const scene::Camera view = render::fitted(internalCamera(camera, impl.scene), settings.cameraFit);
  const render::SceneState moment = internalState(options, settings, impl.scene, 1);
  for (const render::Picked& p : render::pick(impl.renderer, impl.scene, view, settings, places, moment).picked)
    picks.push_back({p.id,
                     p.part,
                     p.node,
                     p.mesh,
                     p.material,
                     p.primitive,
                     three(p.position),
                     three(p.normal),
                     three(p.geonormal),
                     p.depth,
                     p.distance,
                     {p.uv.x, p.uv.y}});
  return picks;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the picked points");
}

}  // namespace latelight
