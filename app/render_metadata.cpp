#include "app/render_metadata.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "render/id_manifest.h"
#include "render/session.h"
#include "render/view.h"

namespace latelight::app {

namespace {

output::CameraMetadata describeCamera(const scene::Camera& camera, const scene::Scene& scene, const RenderOptions& o) {
  const render::Settings& s = o.settings;
  const shared::View view = render::makeView(camera, s.width, s.height);
  output::CameraMetadata m;
  m.name = camera.name;
  const double halfWidth = s.width * 0.5, halfHeight = s.height * 0.5;
  const shared::Projection& p = view.projection;
  m.intrinsics = {p.H * halfWidth, 0, halfWidth * (1 + p.X), 0, p.V * halfHeight, halfHeight * (1 - p.Z), 0, 0, 1};
  m.cameraToWorld = render::openCvPose(camera, scene, s.zUp);
  m.orthographic = camera.orthographic;
  m.nearClip = camera.nearClip;
  m.farClip = camera.farClip;
  return m;
}

std::map<std::string, std::string> describeSettings(const RenderOptions& o, const std::string& environment) {
  const render::Settings& s = o.settings;
  std::map<std::string, std::string> settings = {
      {"size", fmt::format("{}x{}", s.width, s.height)},
      {"layout", s.layout},
      {"normals", s.normals},
      {"normal-space", s.normalSpace},
      {"position", s.position},
      {"lighting", s.lighting},
      {"shading", s.shading},
      {"tonemap", s.tonemap},
      {"volumes-order", s.volumesOrder},
      {"transparency", s.transparency},
      {"data-surfaces", s.dataSurfaces},
      {"shadows", s.shadows},
      {"shadow-filter", s.shadowFilter},
      {"shadow-lights", s.shadowLights},
      {"shadow-atlas", fmt::format("{}", s.shadowAtlas)},
      {"light-size", fmt::format("{}", s.lightSize)},
      {"sun-angle", fmt::format("{}", o.sunAngle)},
      {"sun", o.sun.empty() ? "none" : o.sun},
      {"aa", o.aa},
      {"anisotropy", s.anisotropy ? fmt::format("{}", *s.anisotropy) : "by the device"},
      {"exposure", fmt::format("{}", s.exposure)},
      {"hdri", environment.empty() ? "none" : environment},
      {"hdri-rotate", fmt::format("{}", o.hdriRotate)},
      {"hdri-intensity", fmt::format("{}", s.environmentIntensity)},
      {"background", o.background},
      {"ao", s.ao.method},
      {"ao-radius", s.ao.radius ? fmt::format("{}", *s.ao.radius) : "by the scene"},
      {"ao-strength", fmt::format("{}", s.ao.strength)},
      {"bloom", fmt::format("{}", s.bloom.strength)},
      {"bloom-radius", fmt::format("{}", s.bloom.radius)},
      {"bloom-threshold", fmt::format("{}", s.bloom.threshold)},
      {"bloom-fireflies", s.bloom.fireflies},
      {"fog", fmt::format("{}", s.fog.density)},
      {"fog-color", o.fogColor},
      {"fog-height", fmt::format("{}", s.fog.height)},
      {"fog-base", fmt::format("{}", s.fog.base)}};
  if (o.time) settings["time"] = fmt::format("{}", *o.time);
  if (o.time || o.turn != 0) settings["fps"] = fmt::format("{}", o.fps);
  if (!o.animation.empty()) settings["animation"] = o.animation;
  if (o.loop) settings["loop"] = "true";
  if (o.idGrouping.depth) settings["id-depth"] = fmt::format("{}", *o.idGrouping.depth);
  if (!o.idGrouping.nodes.empty()) settings["id-nodes"] = o.idNodes;
  if (o.turn != 0) settings["turn"] = fmt::format("{}", o.turn);
  return settings;
}

}  // namespace

output::Metadata describeRender(const scene::Scene& scene, const scene::Camera& camera, const vk::Device& device,
                                const std::string& environment, const RenderOptions& o) {
  output::Metadata m;
  m.scene = scene.name;
  m.source = scene.source;
  m.frame = o.frame;
  m.camera = describeCamera(camera, scene, o);
  m.axes = scene.yUp && !o.settings.zUp ? "gltf" : "z-up";
  m.normalFrame = o.normalFrame;
  m.exposure = std::exp2(o.settings.exposure);
  m.device = {device.info().name, device.info().driver, device.info().uuid};
  m.versions = {{"latelight", LATELIGHT_VERSION}, {"vulkan", device.info().apiVersion}};
  m.settings = describeSettings(o, environment);
  if (std::ranges::any_of(o.settings.aovs, output::holdsIds)) m.ids = render::idManifest(scene);
  return m;
}

}  // namespace latelight::app
