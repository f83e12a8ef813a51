// The settings and the scene's state of a call, from its options and cameras.
#include "api/settings.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "api/scene.h"
#include "base/error.h"
#include "base/log.h"
#include "output/aov.h"
#include "render/options/options.h"

namespace latelight {

Exposure Exposure::fromText(const std::string& text) {
  const auto read = render::readText<render::Exposure>("--exposure", text);
  Exposure exposure(read.ev);
  exposure.automatic = read.automatic;
  return exposure;
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

}  // namespace

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

render::Settings settingsFor(vk::Device& device, const Options& o, const scene::Scene& scene, render::RasterUse use) {
  render::Settings s = internalSettings(o);
  checkPlayback(s);
  s.raster = render::chooseRaster(device, s, scene, use).raster;
  return s;
}

render::RasterUse rasterUseOf(const Worlds& worlds) {
  return worlds.joints.empty() && worlds.meshes.empty() ? render::RasterUse::Worlds : render::RasterUse::DeformedWorlds;
}

MemoryClaim claimCameras(uint64_t cameras) {
  return {cameras * kCameraBytes, "the cameras of the call"};
}

std::vector<scene::Camera> internalCameras(const std::vector<Camera>& cameras, const scene::Scene& scene, size_t count,
                                           render::CameraFit fit) {
  if (!cameras.empty() && cameras.size() != count)
    badUsage("{} cameras are rendered, but {} are given for another frame", count, cameras.size());
  std::vector<scene::Camera> internal;
  internal.reserve(cameras.size());
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

double shutterOf(const Camera& camera, double usual) {
  const double shutter = camera.shutter.value_or(usual);
  static const render::Range& range = render::rangeOf("--shutter");
  if (!range.holds(shutter))
    badUsage("a camera's shutter must be from {} to {} seconds, not {}", range.least, range.most, shutter);
  return shutter;
}

double readoutOf(const Camera& camera, double usual) {
  const double readout = camera.readout.value_or(usual);
  static const render::Range& range = render::rangeOf("--readout");
  if (!range.holds(readout))
    badUsage("a camera's readout must be from {} to {} seconds, not {}", range.least, range.most, readout);
  return readout;
}

double exposureOf(const Camera& camera, double usual) {
  const double exposure = camera.exposure.value_or(usual);
  if (!render::isValidExposure(exposure))
    badUsage("a camera's exposure must be from -{} to {} EV, not {}", render::kMaxExposure, render::kMaxExposure,
             exposure);
  return exposure;
}

namespace {

// Returns a value per camera, or none if no camera has one of its own.
std::vector<double> ownValues(const std::vector<Camera>& cameras, std::optional<double> Camera::*own,
                              double (*valueOf)(const Camera&, double), double usual) {
  std::vector<double> values;
  if (std::ranges::any_of(cameras, [own](const Camera& camera) { return (camera.*own).has_value(); }))
    for (const Camera& camera : cameras) values.push_back(valueOf(camera, usual));
  return values;
}

}  // namespace

void setExposures(render::SceneState& moment, const std::vector<Camera>& cameras, const render::Settings& settings) {
  moment.shutters = ownValues(cameras, &Camera::shutter, shutterOf, settings.shutter);
  moment.readouts = ownValues(cameras, &Camera::readout, readoutOf, settings.readout);
  moment.exposures = ownValues(cameras, &Camera::exposure, exposureOf, settings.exposure.ev);
}

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

}  // namespace latelight
