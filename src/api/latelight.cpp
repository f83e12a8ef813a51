// The public API of include/latelight/latelight.h.
#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <utility>
#include <variant>

#include "api/device_array.h"
#include "api/renderer.h"
#include "api/scene.h"
#include "api/transform.h"
#include "base/error.h"
#include "base/fork.h"
#include "base/log.h"
#include "export/export.h"
#include "output/png.h"
#include "render/options/options.h"
#include "render/submit/id_manifest.h"
#include "render/submit/picking.h"
#include "render/submit/raster_choice.h"
#include "render/submit/renderer.h"
#include "render/submit/session.h"
#include "scene/framing.h"
#include "scene/load/load.h"
#include "scene/mesh_files/polygon.h"
#include "scene/rig_edit.h"
#include "vk/read_back.h"
#include "vk/shared_timeline.h"

namespace latelight {

namespace {

Lens publicLens(const scene::Lens& from) {
  return {
      static_cast<LensModel>(from.model), from.width, from.height, from.fx, from.fy, from.cx, from.cy, from.distortion};
}

}  // namespace

Camera publicCamera(const scene::Camera& camera, const scene::Scene& scene) {
  Camera c;
  c.name = camera.name;
  c.cameraToWorld = rowsOf(render::openCvPose(camera, scene, false));
  c.orthographic = camera.orthographic;
  c.verticalFov = camera.verticalFov * kDegreesPerRadian;
  c.halfHeight = camera.yHalf;
  c.aspect = camera.aspect;
  c.nearClip = camera.nearClip;
  c.farClip = camera.farClip;
  c.principalX = camera.principal.x;
  c.principalY = camera.principal.y;
  if (camera.lens) c.lens = publicLens(*camera.lens);
  if (camera.aperture) c.aperture = scene::apertureText(*camera.aperture);
  c.focusDistance = camera.focusDistance;
  c.noiseSeed = static_cast<uint32_t>(camera.noiseSeed);
  return c;
}

namespace {

render::SunLight internalSun(const Sun& sun) {
  return {sun.azimuth / kDegreesPerRadian, sun.elevation / kDegreesPerRadian, sun.illuminance};
}

// Returns true for the shorter of two formats.
bool isShorter(const std::string& name, const std::string& format, const char* usual, const char* shorter) {
  if (format != usual && format != shorter)
    badUsage("the format of {} must be {} or {}, not \"{}\"", name, usual, shorter, printable(format));
  return format == shorter;
}

render::ExportFormats internalFormats(const Options& o, const render::Settings& s) {
  render::ExportFormats formats{.rgb = false, .shorter = {}, .channelsFirst = o.channelsFirst};
  for (const auto& [name, format] : o.formats) {
    if (name == "rgba" && s.display) {
      formats.rgb = isShorter(name, format, "rgba8", "rgb8");
      continue;
    }
    const auto aov = std::ranges::find(s.aovs, name, [](output::Aov aov) { return output::info(aov).name; });
    if (aov == s.aovs.end()) badUsage("formats has \"{}\", which is not one of the requested outputs", printable(name));
    const bool ids = output::holdsIntegers(*aov);
    if (isShorter(name, format, ids ? "uint32" : "float32", ids ? "uint16" : "float16"))
      formats.shorter.push_back(*aov);
  }
  return formats;
}

render::Settings internalSettings(const Options& o) {
  render::Settings s;
#define OPTION_FLAG(member, ...) s.member = o.member;
#define OPTION_NUMBER(Type, member, ...) s.member = o.member;
#define OPTION_ANGLE(member, ...) s.member = render::radians(o.member);
#define OPTION_OPTIONAL(Type, member, ...) s.member = o.member;
#define OPTION_CHOICE(Enum, member, name, ...) s.member = render::readChoice<decltype(s.member)>(name, o.member);
#define OPTION_ENTRY(Type, member, name, ...) s.member = &render::readEntry<render::Type>(name, o.member);
#define OPTION_TEXT(Type, member, name, ...) s.member = render::readText<decltype(s.member)>(name, o.member);
#define OPTION_SIZE(width, height, ...) s.width = o.width, s.height = o.height;
#define OPTION_SUN(member, ...) \
  if (o.member) s.member = internalSun(*o.member);
#define OPTION_EXPOSURE(member, ...) s.member = {o.member.ev, o.member.automatic};
#include <latelight/options.def>
  s.display = o.picture;
  if (!o.aovs.empty()) s.aovs = output::parseAovs(fmt::format("{}", fmt::join(o.aovs, ",")));
  s.exports = internalFormats(o, s);
  render::checkSettings(s);
  return s;
}

void checkPlayback(const render::Settings& s) {
  if (render::playsWithoutTime(s)) badUsage("--animation and --loop require --time");
}

render::Settings settingsFor(vk::Device& device, const Options& o, const scene::Scene& scene,
                             render::RasterUse use = render::RasterUse::Image) {
  render::Settings s = internalSettings(o);
  checkPlayback(s);
  s.raster = render::chooseRaster(device, s, scene, use).raster;
  return s;
}

void checkTime(double time) {
  if (!std::isfinite(time)) badUsage("the time must be a number of seconds");
}

std::vector<scene::Camera> internalCameras(const std::vector<Camera>& cameras, const scene::Scene& scene, size_t count,
                                           render::CameraFit fit) {
  if (!cameras.empty() && cameras.size() != count)
    badUsage("{} cameras are rendered, but {} are given for another frame", count, cameras.size());
  std::vector<scene::Camera> internal;
  for (const Camera& camera : cameras) internal.push_back(render::fitted(internalCamera(camera, scene), fit));
  return internal;
}

render::SceneState internalState(const Options& o, const render::Settings& s, const scene::Scene& scene,
                                 size_t cameras) {
  render::SceneState moment;
  moment.previousCameras = internalCameras(o.previousCameras, scene, cameras, s.cameraFit);
  moment.nextCameras = internalCameras(o.nextCameras, scene, cameras, s.cameraFit);
  moment.continues = o.continues;
  moment.poses = render::posesAt(scene, s);
  moment.motion = render::motionNear(scene, s);
  return moment;
}

constexpr double kLongestExposure = 1e4;  // seconds, as for the options

double shutterOf(const Camera& camera, double usual) {
  const double shutter = camera.shutter.value_or(usual);
  if (!(shutter >= 0 && shutter <= kLongestExposure))
    badUsage("a camera's shutter must be from 0 to {} seconds, not {}", kLongestExposure, shutter);
  return shutter;
}

double readoutOf(const Camera& camera, double usual) {
  const double readout = camera.readout.value_or(usual);
  if (!(std::abs(readout) <= kLongestExposure))
    badUsage("a camera's readout must be from {} to {} seconds, not {}", -kLongestExposure, kLongestExposure, readout);
  return readout;
}

double exposureOf(const Camera& camera, double usual) {
  const double exposure = camera.exposure.value_or(usual);
  if (!(std::abs(exposure) <= render::kMaxExposure))
    badUsage("a camera's exposure must be from -{} to {} EV, not {}", render::kMaxExposure, render::kMaxExposure,
             exposure);
  return exposure;
}

// Returns a value per camera, or none if no camera has one of its own.
std::vector<double> ownValues(const std::vector<Camera>& cameras, std::optional<double> Camera::*own,
                              double (*valueOf)(const Camera&, double), double usual) {
  std::vector<double> values;
  if (std::ranges::any_of(cameras, [own](const Camera& camera) { return (camera.*own).has_value(); }))
    for (const Camera& camera : cameras) values.push_back(valueOf(camera, usual));
  return values;
}

// Writes the cameras' own exposures.
void setExposures(render::SceneState& moment, const std::vector<Camera>& cameras, const render::Settings& settings) {
  moment.shutters = ownValues(cameras, &Camera::shutter, shutterOf, settings.shutter);
  moment.readouts = ownValues(cameras, &Camera::readout, readoutOf, settings.readout);
  moment.exposures = ownValues(cameras, &Camera::exposure, exposureOf, settings.exposure.ev);
}

// Returns the settings of a single camera's picture.
render::Settings withExposure(render::Settings settings, const Camera& camera) {
  settings.shutter = shutterOf(camera, settings.shutter);
  settings.readout = readoutOf(camera, settings.readout);
  settings.exposure.ev = static_cast<float>(exposureOf(camera, settings.exposure.ev));
  return settings;
}

void rejectExposures(const std::vector<Camera>& cameras) {
  for (const Camera& camera : cameras)
    if (shutterOf(camera, 0) != 0 || readoutOf(camera, 0) != 0)
      badUsage("worlds are rendered at an instant: leave out the shutter and readout of their cameras");
  if (std::ranges::any_of(cameras, [](const Camera& camera) { return camera.exposure.has_value(); }))
    badUsage("the cameras of worlds have the exposure of the options: leave out their own");
}

render::Results internalResults(Results results) {
  switch (results) {
    case Results::OnDevice:
      return render::Results::OnDevice;
    case Results::Arrays:
      return render::Results::Exported;
    default:
      return render::Results::ToHost;
  }
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

scene::Environment makeEnvironment(const EnvironmentData& data) {
  if (data.height == 0 || data.width != 2 * data.height)
    badUsage("an environment is twice as wide as it is high, and not {}x{} pixels", data.width, data.height);
  if (data.radiance.size() != size_t{data.width} * data.height)
    badUsage("an environment of {}x{} pixels needs one radiance per pixel, but {} are given", data.width, data.height,
             data.radiance.size());
  scene::FloatImage picture(data.width, data.height);
  for (size_t i = 0; i < data.radiance.size(); ++i)
    for (size_t channel = 0; channel < 4; ++channel)
      picture.pixels[4 * i + channel] = channel < 3 ? data.radiance[i][channel] : 1;
  return scene::makeEnvironment(std::move(picture));
}

}  // namespace

std::vector<std::array<uint32_t, 3>> triangulate(std::span<const std::array<float, 3>> polygon) {
  std::vector<scene::vec3> corners;
  corners.reserve(polygon.size());
  for (const auto& [x, y, z] : polygon) corners.emplace_back(x, y, z);
  std::vector<std::array<uint32_t, 3>> triangles;
  scene::mesh_files::triangulate(corners, triangles);
  return triangles;
}

EnvironmentData readEnvironment(const std::string& file) {
  const scene::FloatImage image = scene::readPicture(file);
  EnvironmentData data{.width = image.width, .height = image.height, .radiance = {}};
  data.radiance.resize(size_t{image.width} * image.height);
  for (size_t i = 0; i < data.radiance.size(); ++i)
    for (size_t channel = 0; channel < 3; ++channel) data.radiance[i][channel] = image.pixels[4 * i + channel];
  return data;
}

std::vector<std::byte> encodePng(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba) {
  if (width == 0 || height == 0 || rgba.size() != size_t{4} * width * height)
    badUsage("an image of {}x{} pixels has 4 bytes per pixel, but {} bytes are given", width, height, rgba.size());
  return output::encodePng(output::Picture{width, height, rgba});
}

Exposure Exposure::fromText(const std::string& text) {
  const auto read = render::readText<render::Exposure>("--exposure", text);
  Exposure exposure(read.ev);
  exposure.automatic = read.automatic;
  return exposure;
}

Scene::Scene() : impl_(new Impl{scene::Scene{.name = "scene", .source = "scene"}}) {}

Scene::Scene(const std::string& source, const std::string& materialVariant)
    : Scene(source, SceneOptions{.materialVariant = materialVariant}) {}

Scene::Scene(const std::string& source, const SceneOptions& options)
    : impl_(new Impl{scene::load(source, {.variant = options.materialVariant,
                                          .allowOutside = options.allowOutside,
                                          .ids = {options.idDepth, options.idNodes},
                                          .unit = options.unit,
                                          .upAxis = options.upAxis,
                                          .pointRadius = options.pointRadius,
                                          .morphTargets = true})}) {
  for (const scene::Animation& animation : impl_->scene.rig.animations)
    impl_->animations.push_back({animation.name, animation.duration});
  for (const scene::Camera& camera : impl_->scene.cameras) impl_->cameras.push_back(publicCamera(camera, impl_->scene));
}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

Scene::Impl& Scene::filled() const {
  if (!impl_) badUsage("this scene has been moved to another object: use that one");
  return *impl_;
}

uint64_t Scene::triangleCount() const {
  return filled().scene.triangleCount();
}
void Scene::exportTo(const std::string& file) const {
  exports::exportScene(filled().scene, file);
}
void Scene::setEnvironment(const EnvironmentData& environment) {
  auto made = std::make_shared<scene::Environment>(makeEnvironment(environment));
  made->name = "environment of the scene";
  filled().scene.environment = std::move(made);
}
std::string Scene::idManifest() const {
  return output::idManifestText(render::idManifest(filled().scene));
}
const std::vector<Camera>& Scene::cameras() const {
  return filled().cameras;
}

const std::vector<Animation>& Scene::animations() const {
  return filled().animations;
}

Camera Scene::Impl::posedCamera(size_t index, const scene::Camera& posed) const {
  Camera camera = publicCamera(posed, scene);
  camera.shutter = cameras[index].shutter;
  camera.readout = cameras[index].readout;
  camera.exposure = cameras[index].exposure;
  return camera;
}

void Scene::addCamera(const Camera& camera) {
  shutterOf(camera, 0), readoutOf(camera, 0), exposureOf(camera, 0);  // reject invalid values
  const size_t index = filled().cameras.size();
  filled().scene.cameras.push_back(internalCamera(camera, filled().scene));
  filled().cameras.push_back(camera);
  filled().cameras[index] = filled().posedCamera(index, filled().scene.cameras[index]);
}

void Scene::addCamera(const Camera& camera, const std::string& node) {
  const uint32_t index = filled().nodeAt(node);
  scene::rigNodeOf(filled().scene, index);
  addCamera(camera);
  scene::Camera& added = filled().scene.cameras.back();
  added.node = static_cast<int>(index);
  filled().scene.nodes[index].followed = true;
  scene::placeCamera(added, scene::toGltfFromWorld() * filled().scene.nodes[index].toWorld);
  filled().cameras.back() = filled().posedCamera(filled().cameras.size() - 1, added);
}

std::vector<Camera> Scene::camerasAt(double time, const std::string& animation, bool loop) const {
  checkTime(time);
  const scene::Scene& scene = filled().scene;
  const scene::Pose pose = scene::poseAt(scene, scene::choosePlayback(scene, animation, loop), time);
  std::vector<Camera> cameras;
  for (const scene::Camera& posed : scene::posedCameras(scene, pose))
    cameras.push_back(filled().posedCamera(cameras.size(), posed));
  return cameras;
}

Camera Scene::defaultCamera(float aspect, std::optional<double> time, const std::string& animation, bool loop) const {
  if (!filled().cameras.empty()) return time ? camerasAt(*time, animation, loop).front() : filled().cameras.front();
  if (!(aspect > 0) || !std::isfinite(aspect)) badUsage("a picture's aspect must be a number above 0, not {}", aspect);
  return publicCamera(scene::frameScene(filled().scene, aspect), filled().scene);
}

Camera Scene::lookAt(std::array<double, 3> eye, std::array<double, 3> target, float verticalFov) const {
  return publicCamera(scene::lookAt(filled().scene, {eye[0], eye[1], eye[2]}, {target[0], target[1], target[2]}, {},
                                    verticalFovOf(verticalFov)),
                      filled().scene);
}

namespace {

// Returns the renderer. Fails in any process other than the one that created it.
template <typename Impl>
Impl& usable(const std::shared_ptr<Impl>& renderer) {
  renderer->owner.require("the renderer");
  return *renderer;
}

}  // namespace

Renderer::Renderer(const Scene& scene, const std::string& device, const EnvironmentData& environment)
    : impl_(ownedByProcess(new Impl(scene.filled(), device, makeEnvironment(environment)))) {}
Renderer::Renderer(const Scene& scene, const std::string& device, const std::string& environment)
    : impl_(ownedByProcess(
          new Impl(scene.filled(), device,
                   render::loadEnvironment(scene.filled().scene,
                                           render::environmentName(scene.filled().scene, environment, false))))) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

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
  filled().device->whileWaiting(std::move(check));
}

void Renderer::finish() {
  filled().device->finish();
}

Frame Renderer::render(const Camera& camera, const Options& options) {
  return std::move(render(std::vector<Camera>{camera}, options).front());
}

std::vector<Frame> Renderer::render(const std::vector<Camera>& cameras, const Options& options) {
  return submit(cameras, options).take();
}

struct Ticket::Impl {
  std::shared_ptr<Renderer::Impl> renderer;
  render::Ticket ticket;
  Results results;
  std::vector<uint32_t> invalidWorlds{};
  bool awaitsWorlds = false;  // the device reports invalid worlds

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
  return !impl_ || (usable(impl_->renderer), impl_->ticket.done());
}

std::vector<float> Ticket::exposures() const {
  if (!impl_) badUsage("these pictures have been taken already");
  usable(impl_->renderer);
  return impl_->ticket.exposures();
}

std::vector<Frame> Ticket::take() {
  if (!impl_) badUsage("these pictures have been taken already");
  usable(impl_->renderer);
  if (impl_->results == Results::Arrays) badUsage("these pictures are arrays on the device: take those");
  const std::shared_ptr<Impl> taken = std::move(impl_);
  taken->checkWorlds();
  std::vector<Frame> frames;
  for (output::FrameOutput& frame : taken->ticket.take().frames) frames.push_back(publicFrame(std::move(frame)));
  return frames;
}

struct DeviceArray::Impl {
  OwnerProcess owner;
  std::shared_ptr<vk::Device> device;  // destroyed after the memory
  std::shared_ptr<render::ExportedMemory> memory;
};

std::map<std::string, DeviceArray> Ticket::takeArrays() {
  if (!impl_) badUsage("these pictures have been taken already");
  usable(impl_->renderer);
  if (impl_->results != Results::Arrays) badUsage("these pictures are no arrays: submit them with Results::Arrays");
  const std::shared_ptr<Impl> taken = std::move(impl_);
  taken->checkWorlds();
  std::map<std::string, DeviceArray> arrays;
  for (render::ExportedArray& from : taken->ticket.take().arrays) {
    DeviceArray& array = arrays[from.aov ? std::string(output::info(*from.aov).name) : "rgba"];
    using enum DeviceArray::Element;
    const bool integers = from.aov && output::holdsIntegers(*from.aov), shorter = from.elementBytes == 2;
    array.element = !from.aov ? Uint8 : integers ? (shorter ? Uint16 : Uint32) : shorter ? Float16 : Float32;
    array.shape = {from.views, from.rows, from.columns, from.channels};
    array.channelsFirst = from.channelsFirst;
    if (from.channelsFirst) array.shape = {from.views, from.channels, from.rows, from.columns};
    array.impl_ = ownedByProcess(
        new DeviceArray::Impl{.owner = {}, .device = taken->renderer->device, .memory = std::move(from.memory)});
  }
  return arrays;
}

const vk::Buffer& DeviceArrayMemory::bufferOf(const DeviceArray& array) {
  return array.impl_->memory->buffer;
}
std::shared_ptr<const void> DeviceArrayMemory::held(const DeviceArray& array) {
  return array.impl_->memory;
}
std::shared_ptr<render::ExportedMemory> DeviceArrayMemory::of(const DeviceArray& array, const vk::Device& device,
                                                              const std::string& role) {
  if (!array.impl_) badUsage("{} is empty", role);
  // Addresses and handles of Vulkan are those of a single VkDevice, even if two renderers share the physical device.
  if (array.impl_->device.get() != &device)
    badUsage("{} belongs to another renderer: use an array of the renderer that is called", role);
  return array.impl_->memory;
}
bool DeviceArrayMemory::contains(const DeviceArray& array, uint64_t offset, uint64_t count, uint64_t eachBytes) {
  using enum DeviceArray::Element;
  uint64_t bytes = array.element == Uint8 ? 1 : array.element == Float16 || array.element == Uint16 ? 2 : 4;
  for (const uint64_t length : array.shape) bytes *= length;
  // The renderer's memory may be larger than the array, and a caller may have changed the array's public shape.
  const uint64_t size = std::min(bytes, uint64_t{bufferOf(array).size()});
  return offset <= size && (count == 0 || eachBytes <= (size - offset) / count);
}
void DeviceArrayMemory::checkDistinct(const std::map<std::string, DeviceArray>& arrays) {
  for (auto a = arrays.begin(); a != arrays.end(); ++a)
    for (auto b = std::next(a); b != arrays.end(); ++b)
      if (a->second.impl_ && b->second.impl_ && a->second.impl_->memory == b->second.impl_->memory)
        badUsage("the outputs {} and {} have the same array: use one array per output", printable(a->first),
                 printable(b->first));
}

const DeviceArray::Impl& DeviceArray::filled() const {
  if (!impl_) badUsage("this array is empty: use one that takeArrays(), cast() or inputArray() has returned");
  return *impl_;
}
const void* DeviceArray::host() const {
  return filled().memory->buffer.mapped();
}
int DeviceArray::exportMemory() const {
  filled().owner.require("the array's device");
  if (host()) badUsage("the host has this array: it is read there");
  return filled().memory->buffer.exportMemory();
}
uint64_t DeviceArray::memoryBytes() const {
  return filled().memory->buffer.memorySize();
}
void DeviceArray::copyToHost(std::span<std::byte> to) const {
  filled().owner.require("the array's device");
  const vk::Buffer& from = filled().memory->buffer;
  if (to.size() > from.size()) badUsage("the array has {} bytes, not {}", from.size(), to.size());
  if (host()) {
    std::memcpy(to.data(), host(), to.size());
    return;
  }
  vk::readBack(*filled().device, from, 0, to);
}
std::string DeviceArray::deviceUuid() const {
  return filled().device->info().uuid;
}
void DeviceArray::attach(std::shared_ptr<void> object) const {
  filled().memory->attached = std::move(object);
}
std::shared_ptr<void> DeviceArray::attached() const {
  return filled().memory->attached;
}
void DeviceArray::beforeReuse(std::function<void()> call) const {
  filled().memory->beforeReuse = std::move(call);
}

render::ExportTargets DeviceArrayMemory::targets(const std::map<std::string, DeviceArray>& arrays,
                                                 const vk::Device& device) {
  render::ExportTargets targets;
  for (const auto& [name, array] : arrays) {
    const output::AovInfo* info = output::findAov(name);
    if (!info && name != "rgba") badUsage("there is no output \"{}\" to render into", printable(name));
    targets[info ? std::optional(info->aov) : std::nullopt] =
        of(array, device, fmt::format("the array to render {} into", name));
  }
  checkDistinct(arrays);
  return targets;
}

namespace {

// Whoever reads the arrays must have finished. `ordered`: the device waits for them.
render::ExportTargets targetsOf(const std::map<std::string, DeviceArray>& arrays, const vk::Device& device,
                                Results results, bool ordered) {
  if (!arrays.empty() && results != Results::Arrays) badUsage("only Results::Arrays are rendered into given arrays");
  render::ExportTargets targets = DeviceArrayMemory::targets(arrays, device);
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
                        const std::map<std::string, DeviceArray>& targets) {
  filled();
  checkFormats(options, results);
  if (cameras.empty()) badUsage("nothing can be rendered without a camera");
  const render::Settings settings = settingsFor(*impl_->device, options, impl_->scene);
  const std::vector<scene::Camera> internal =
      internalCameras(cameras, impl_->scene, cameras.size(), settings.cameraFit);
  render::SceneState moment = internalState(options, settings, impl_->scene, cameras.size());
  setExposures(moment, cameras, settings);
  Ticket ticket;
  ticket.impl_ =
      ownedByProcess(new Ticket::Impl{impl_,
                                      impl_->renderer.submit(internal, settings, moment, internalResults(results),
                                                             targetsOf(targets, *impl_->device, results, false)),
                                      results});
  return ticket;
}

std::vector<Frame> Renderer::render(const Worlds& worlds, const Options& options) {
  return submit(worlds, options).take();
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
                        const std::map<std::string, DeviceArray>& targets) {
  filled();
  checkFormats(options, results);
  if (!options.previousCameras.empty() || !options.nextCameras.empty())
    badUsage("worlds have previous and next cameras of their own: leave those of the options empty");
  rejectExposures(worlds.cameras);
  const render::Settings settings = settingsFor(*impl_->device, options, impl_->scene, render::RasterUse::Worlds);
  render::SceneState moment = internalState(options, settings, impl_->scene, 0);
  if (worlds.arrays.ready > 0 && impl_->inputTimeline)
    impl_->device->waitFirst(impl_->inputTimeline->get(), worlds.arrays.ready);
  moment.worlds.environments = impl_->environmentsOf(worlds.environments);
  const WorldCameras internal = impl_->source.convert(worlds, settings, moment, impl_->renderer, *impl_->device);
  Ticket ticket;
  ticket.impl_ = ownedByProcess(
      new Ticket::Impl{impl_,
                       impl_->renderer.submit(internal.cameras, settings, moment, internalResults(results),
                                              targetsOf(targets, *impl_->device, results, worlds.arrays.ready > 0)),
                       results, internal.invalid, internal.onDevice});
  return ticket;
}

std::shared_ptr<const DeviceArray> Renderer::inputArray(uint64_t bytes) {
  vk::Device& device = *filled().device;
  auto array = std::make_shared<DeviceArray>();
  array->element = DeviceArray::Element::Uint8;
  array->shape = {1, 1, 1, bytes};
  const uint64_t padded = (std::min(bytes, ~uint64_t{0} - 15) + 15) / 16 * 16;
  array->impl_ = ownedByProcess(
      new DeviceArray::Impl{.owner = {}, .device = impl_->device, .memory = impl_->inputs->take(device, padded)});
  return array;
}

int Renderer::exportInputSemaphore() {
  Impl& impl = filled();
  if (!impl.inputTimeline) impl.inputTimeline.emplace(*impl.device);
  return impl.inputTimeline->exportSemaphore();
}

const std::vector<uint32_t>& Ticket::invalidWorlds() const {
  if (!impl_) badUsage("these pictures have been taken already");
  usable(impl_->renderer);
  impl_->checkWorlds();
  return impl_->invalidWorlds;
}

std::vector<Pick> Renderer::pick(const Camera& camera, const std::vector<std::array<uint32_t, 2>>& pixels,
                                 const Options& options) {
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
}

namespace {

// The public vectors have the layout of glm's.
std::span<const glm::dvec3> vectors(std::span<const std::array<double, 3>> arrays) {
  static_assert(sizeof(glm::dvec3) == sizeof(std::array<double, 3>));
  return {reinterpret_cast<const glm::dvec3*>(arrays.data()), arrays.size()};
}

}  // namespace

Renderer::Impl::LabelInput Renderer::Impl::labelInput(const Camera& camera, const Options& options) const {
  owner.require("the renderer");
  const render::Settings settings = withExposure(settingsFor(*device, options, scene), camera);
  return {.camera = render::fitted(internalCamera(camera, scene), settings.cameraFit),
          .settings = settings,
          .moment = internalState(options, settings, scene, 1)};
}

Renderer::Impl::WorldLabelInput Renderer::Impl::worldLabelInput(const Worlds& worlds, const Options& options) {
  owner.require("the renderer");
  WorldLabelInput input{
      .cameras = {}, .settings = settingsFor(*device, options, scene, render::RasterUse::Worlds), .moment = {}};
  if (input.settings.shutter != 0 || input.settings.readout != 0)
    badUsage("worlds do not support an exposure time and a rolling shutter: omit shutter and readout");
  rejectExposures(worlds.cameras);
  input.moment = internalState(options, input.settings, scene, 0);
  if (worlds.arrays.ready > 0 && inputTimeline) device->waitFirst(inputTimeline->get(), worlds.arrays.ready);
  input.cameras = source.convert(worlds, input.settings, input.moment, renderer, *device, true).cameras;
  input.moment.previousCameras.clear();
  input.moment.nextCameras.clear();
  return input;
}

Renderer::Impl::RayInput Renderer::Impl::rayInput(const Options& options) const {
  owner.require("the renderer");
  RayInput input{.settings = internalSettings(options), .moment = {}};
  input.moment = internalState(options, input.settings, scene, 0);
  return input;
}

namespace {

std::span<const glm::vec3> vectors(std::span<const std::array<float, 3>> arrays) {
  static_assert(sizeof(glm::vec3) == sizeof(std::array<float, 3>));
  return {reinterpret_cast<const glm::vec3*>(arrays.data()), arrays.size()};
}

render::CastRays raysOf(std::span<const std::array<double, 3>> origins,
                        std::span<const std::array<double, 3>> directions, double maxDistance) {
  return {vectors(origins), vectors(directions), maxDistance};
}
render::CastRays raysOf(std::span<const std::array<float, 3>> origins, std::span<const std::array<float, 3>> directions,
                        double maxDistance) {
  return {.maxDistance = maxDistance, .floatOrigins = vectors(origins), .floatDirections = vectors(directions)};
}

// Throws Error(Usage) if the arrays of two outputs overlap. `count`: the number of values in each.
void checkDistinct(const CastTargets& t, uint64_t count) {
  struct Range {
    const char* name;
    std::uintptr_t begin, end;
  };
  std::vector<Range> ranges;
  const auto add = [&](const char* name, const auto* array) {
    const auto begin = reinterpret_cast<std::uintptr_t>(array);
    if (array) ranges.push_back({name, begin, begin + count * sizeof(*array)});
  };
  add("distance", t.distance), add("position", t.position), add("normal", t.normal), add("geonormal", t.geonormal);
  add("uv", t.uv), add("id", t.id), add("part", t.part), add("material", t.material), add("triangle", t.triangle);
  add("intensity", t.intensity);
  std::ranges::sort(ranges, {}, &Range::begin);
  for (size_t i = 1; i < ranges.size(); ++i)
    if (ranges[i].begin < ranges[i - 1].end)
      badUsage("the arrays of the outputs {} and {} overlap: use one array per output", ranges[i - 1].name,
               ranges[i].name);
}

render::CastTargets internalTargets(const CastTargets& t, uint64_t count) {
  checkDistinct(t, count);
  static_assert(sizeof(glm::vec3) == sizeof(*t.position) && sizeof(glm::vec2) == sizeof(*t.uv));
  const auto vec3s = [](std::array<float, 3>* vectors) { return reinterpret_cast<glm::vec3*>(vectors); };
  return {t.distance, vec3s(t.position), vec3s(t.normal), vec3s(t.geonormal), reinterpret_cast<glm::vec2*>(t.uv), t.id,
          t.part,     t.material,        t.triangle,      t.intensity};
}

// Renderer::Impl is private, so its type is deduced.
template <typename Impl>
render::CastTicket submitTo(Impl& impl, const render::CastRays& rays, const CastTargets& t, const Options& options,
                            std::function<void()> beforeStore = {}) {
  const auto input = impl.rayInput(options);
  checkPlayback(input.settings);
  const uint64_t count = std::max(rays.origins.size(), rays.floatOrigins.size());
  return impl.renderer.submitCast(rays, internalTargets(t, count), input.settings, input.moment,
                                  std::move(beforeStore));
}

}  // namespace

CastHits Renderer::cast(std::span<const std::array<double, 3>> origins,
                        std::span<const std::array<double, 3>> directions, const Options& options, double maxDistance) {
  filled();
  CastHits hits;
  render::HitMemory<CastTargets, CastHits> memory(hits, origins.size());
  submitTo(*impl_, raysOf(origins, directions, maxDistance), memory.targets(), options, [&] { memory.wait(); }).take();
  return hits;
}

void Renderer::cast(std::span<const std::array<double, 3>> origins, std::span<const std::array<double, 3>> directions,
                    const CastTargets& targets, const Options& options, double maxDistance) {
  submitTo(filled(), raysOf(origins, directions, maxDistance), targets, options).take();
}

void Renderer::cast(std::span<const std::array<float, 3>> origins, std::span<const std::array<float, 3>> directions,
                    const CastTargets& targets, const Options& options, double maxDistance) {
  submitTo(filled(), raysOf(origins, directions, maxDistance), targets, options).take();
}

struct CastTicket::Impl {
  std::shared_ptr<Renderer::Impl> renderer;  // destroyed after the ticket
  std::variant<render::CastTicket, render::WorldCastTicket> ticket;
  bool onDevice;  // the hits are arrays

  template <typename Cast>
  static CastTicket submitted(const std::shared_ptr<Renderer::Impl>& renderer, Cast&& cast, bool onDevice = false) {
    CastTicket ticket;
    ticket.impl_ = ownedByProcess(new Impl{renderer, std::forward<Cast>(cast), onDevice});
    return ticket;
  }
  // Waits for rays through worlds.
  render::WorldHits worldHits() {
    render::WorldHits hits = std::get<render::WorldCastTicket>(ticket).take();
    warnOfInvalidWorlds(worldsOfStatus(hits.worldStatus), hits.worlds);
    return hits;
  }
};

CastTicket::CastTicket() = default;
CastTicket::~CastTicket() = default;
CastTicket::CastTicket(CastTicket&&) noexcept = default;
CastTicket& CastTicket::operator=(CastTicket&&) noexcept = default;

bool CastTicket::done() const {
  if (!impl_) return true;
  usable(impl_->renderer);
  return std::visit([](const auto& cast) { return cast.done(); }, impl_->ticket);
}

void CastTicket::take() {
  if (!impl_) badUsage("these hits have been taken already");
  usable(impl_->renderer);
  if (impl_->onDevice) badUsage("these hits are arrays on the device: take those");
  const std::shared_ptr<Impl> taken = std::move(impl_);
  if (auto* const cast = std::get_if<render::CastTicket>(&taken->ticket))
    cast->take();
  else
    taken->worldHits();
}

std::map<std::string, DeviceArray> CastTicket::takeArrays() {
  if (!impl_) badUsage("these hits have been taken already");
  usable(impl_->renderer);
  if (!impl_->onDevice) badUsage("these hits are no arrays on the device: take() stores them in those of the call");
  const std::shared_ptr<Impl> taken = std::move(impl_);
  render::WorldHits hits = taken->worldHits();
  std::map<std::string, DeviceArray> arrays;
  for (render::WorldCast::Target& from : hits.arrays) {
    DeviceArray& array = arrays[std::string(from.array->name)];
    array.element = from.array->integers ? DeviceArray::Element::Uint32 : DeviceArray::Element::Float32;
    array.shape = {1, hits.worlds, hits.rays, from.array->channels};
    array.impl_ = ownedByProcess(
        new DeviceArray::Impl{.owner = {}, .device = taken->renderer->device, .memory = std::move(from.memory)});
  }
  return arrays;
}

CastTicket Renderer::submitCast(std::span<const std::array<double, 3>> origins,
                                std::span<const std::array<double, 3>> directions, const CastTargets& targets,
                                const Options& options, double maxDistance) {
  return CastTicket::Impl::submitted(impl_,
                                     submitTo(filled(), raysOf(origins, directions, maxDistance), targets, options));
}

CastTicket Renderer::submitCast(std::span<const std::array<float, 3>> origins,
                                std::span<const std::array<float, 3>> directions, const CastTargets& targets,
                                const Options& options, double maxDistance) {
  return CastTicket::Impl::submitted(impl_,
                                     submitTo(filled(), raysOf(origins, directions, maxDistance), targets, options));
}

namespace {

void checkRays(const WorldRays& rays, uint32_t worlds, const vk::Device& device) {
  if (rays.count > render::kMaxWorldRays / std::max(worlds, 1u))
    badUsage("{} rays in each of {} worlds are too many for one call: cast at most {} rays", rays.count, worlds,
             render::kMaxWorldRays);
  for (const auto& [array, name] : {std::pair(&rays.origins, "origins"), std::pair(&rays.directions, "directions")}) {
    if (!*array && rays.count > 0) badUsage("WorldRays::{} must be given", name);
    if (array->host && array->device) badUsage("WorldRays::{} must be in one memory only", name);
    if (array->device) DeviceArrayMemory::of(*array->device, device, fmt::format("WorldRays::{}", name));
    if (array->offset % 16 != 0) badUsage("WorldRays::{} must begin at a multiple of 16 bytes", name);
    if (array->element != WorldArray::Element::Float32 && array->element != WorldArray::Element::Float64)
      badUsage("WorldRays::{} must have elements of the type Float32 or Float64", name);
  }
  if (rays.origins.element != rays.directions.element)
    badUsage("WorldRays::origins and directions must have elements of the same type");
}

// Returns the worlds with what rays read of them.
Worlds worldsOfRays(const Worlds& worlds) {
  Worlds seen = worlds;
  seen.cameras = {Camera{}};
  seen.cameraInstances.clear(), seen.cameraToWorld.clear(), seen.intrinsics.clear();
  seen.previousCameraToWorld.clear(), seen.nextCameraToWorld.clear();
  seen.environments.clear(), seen.environmentIndex.clear();
  for (WorldArray* array : {&seen.arrays.cameraToWorld, &seen.arrays.previousCameraToWorld,
                            &seen.arrays.nextCameraToWorld, &seen.arrays.intrinsics, &seen.arrays.environmentIndex})
    *array = {};
  return seen;
}

// Returns the options with which worlds are converted for rays: shaders place them, and there is no picture.
Options optionsOfRays(Options options) {
  options.raster = "compute";
  options.lighting = "clustered";
  options.shadows = options.indirect = options.ground = "none";
  options.ambientOcclusion = "none";
  options.aa = "none";
  options.aovs.clear();
  return options;
}

// The arrays of a call in memory that the device reads.
VkDeviceAddress addressOf(render::Renderer& renderer, const WorldArray& array, uint64_t bytes,
                          std::vector<std::shared_ptr<const void>>& held) {
  if (array.device) {
    const vk::Buffer& buffer = DeviceArrayMemory::bufferOf(*array.device);
    if (!DeviceArrayMemory::contains(*array.device, array.offset, 1, bytes))
      badUsage("the rays of worlds extend beyond their memory");
    held.push_back(DeviceArrayMemory::held(*array.device));
    return buffer.address() + array.offset;
  }
  if (bytes == 0) return 0;
  const std::shared_ptr<const vk::Buffer> memory = renderer.inputMemory(bytes);
  std::memcpy(memory->mapped(), array.host, bytes);
  held.push_back(memory);
  return memory->address();
}

}  // namespace

std::map<std::string, DeviceArray> Renderer::cast(const Worlds& worlds, const WorldRays& rays,
                                                  const std::vector<std::string>& outputs, const Options& options,
                                                  const std::map<std::string, DeviceArray>& targets) {
  return submitCast(worlds, rays, outputs, options, targets).takeArrays();
}

render::WorldCastTicket Renderer::Impl::submitCast(const Worlds& worlds, const WorldRays& rays,
                                                   std::vector<render::WorldCast::Target>&& hits,
                                                   const Options& options) {
  render::WorldCast call{.doubles = rays.origins.element == WorldArray::Element::Float64,
                         .rays = rays.count,
                         .maxDistance = rays.maxDistance,
                         .hits = std::move(hits)};
  const RayInput input = rayInput(options);
  checkPlayback(input.settings);
  const render::Settings placing = settingsFor(*device, optionsOfRays(options), scene);
  render::SceneState moment = input.moment;
  if (worlds.arrays.ready > 0 && inputTimeline) device->waitFirst(inputTimeline->get(), worlds.arrays.ready);
  source.convert(worldsOfRays(worlds), placing, moment, renderer, *device);
  const uint64_t bytes = uint64_t{worlds.count} * rays.count * 3 * (call.doubles ? sizeof(double) : sizeof(float));
  call.origins = addressOf(renderer, rays.origins, bytes, call.memory);
  call.directions = addressOf(renderer, rays.directions, bytes, call.memory);
  return renderer.submitCast(std::move(call), input.settings, moment);
}

CastTicket Renderer::submitCast(const Worlds& worlds, const WorldRays& rays, const std::vector<std::string>& outputs,
                                const Options& options, const std::map<std::string, DeviceArray>& targets) {
  Impl& impl = filled();
  checkRays(rays, worlds.count, *impl.device);
  DeviceArrayMemory::checkDistinct(targets);
  std::vector<render::WorldCast::Target> hits;
  for (const std::string& name : outputs) {
    const auto found = std::ranges::find(render::hitInfos(), name, &render::HitInfo::name);
    if (found == render::hitInfos().end()) badUsage("rays have no output \"{}\"", printable(name));
    std::shared_ptr<render::ExportedMemory>& memory = hits.emplace_back(&*found).memory;
    const auto target = targets.find(name);
    if (target == targets.end()) continue;
    memory = DeviceArrayMemory::of(target->second, *impl.device, fmt::format("the array to store {} in", name));
    if (worlds.arrays.ready == 0 && memory->beforeReuse) memory->beforeReuse();
  }
  return CastTicket::Impl::submitted(impl_, impl.submitCast(worlds, rays, std::move(hits), options), true);
}

void Renderer::cast(const Worlds& worlds, const WorldRays& rays, const CastTargets& targets, const Options& options) {
  submitCast(worlds, rays, targets, options).take();
}

CastTicket Renderer::submitCast(const Worlds& worlds, const WorldRays& rays, const CastTargets& targets,
                                const Options& options) {
  Impl& impl = filled();
  checkRays(rays, worlds.count, *impl.device);
  return CastTicket::Impl::submitted(
      impl_, impl.submitCast(worlds, rays, render::worldTargets(internalTargets(targets, worlds.count * rays.count)),
                             options));
}

}  // namespace latelight
