#include "app/render_metadata.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <map>

#include "render/gbuffer/layout.h"
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
  m.cameraToWorld = render::openCvPose(camera, scene, s.axes == render::Axes::ZUp);
  m.orthographic = camera.orthographic;
  m.nearClip = camera.nearClip;
  m.farClip = camera.farClip;
  if (!render::bendsRays(camera)) return m;
  const scene::Lens lens = scene::scaledTo(*camera.lens, s.width, s.height);
  m.intrinsics = {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
  m.lens = lens;
  m.nearClip = 0;
  m.farClip = std::numeric_limits<double>::infinity();
  return m;
}

// The settings that the picture depends on, as on the command line. The frames of outputs are stated separately.
std::map<std::string, std::string> describeSettings(const RenderOptions& o, const std::string& environment) {
  std::map<std::string, std::string> settings;
  for (const render::Option& option : render::options()) {
    const auto given = o.given.find(render::keyOf(option));
    const std::string& text = given != o.given.end()  ? given->second
                              : option.normal.empty() ? option.without
                                                      : option.normal;
    if (!text.empty()) settings[std::string(render::keyOf(option))] = text;
  }
  for (const char* elsewhere : {"axes", "normal-frame"}) settings.erase(elsewhere);
  // What `auto` stands for here, and what the camera's lens takes.
  settings["raster"] = render::nameOf(o.settings.raster);
  if (settings.contains("layout")) settings["layout"] = o.settings.layout->name;
  settings["hdri"] = environment.empty() ? "none" : environment;
  const std::optional<double> time = o.settings.time;  // of the frame, in a sequence
  if (time) settings["time"] = fmt::format("{}", *time);
  if (o.idDepth) settings["id-depth"] = fmt::format("{}", *o.idDepth);
  if (!o.idNodes.empty()) settings["id-nodes"] = o.idNodes;
  if (o.turn != 0) settings["turn"] = fmt::format("{}", o.turn);
  if (!time && o.turn == 0) settings.erase("fps");
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
  m.axes = scene.yUp && o.settings.axes == render::Axes::File ? "gltf" : "z-up";
  m.normalFrame = render::nameOf(o.settings.normalFrame);
  m.exposure = render::exposureFactor(o.settings);
  m.device = {device.info().name, device.info().driver, device.info().uuid};
  m.versions = {{"latelight", LATELIGHT_VERSION}, {"vulkan", device.info().apiVersion}};
  m.settings = describeSettings(o, environment);
  if (std::ranges::any_of(o.settings.aovs, output::holdsIds)) m.ids = render::idManifest(scene);
  return m;
}

}  // namespace latelight::app
