#include "render/submit/describe.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "render/exposure/thin_lens.h"
#include "render/frame/view.h"
#include "render/gbuffer/layout.h"
#include "render/options/options.h"
#include "render/outputs/outputs.h"
#include "render/submit/id_manifest.h"
#include "render/submit/session.h"

namespace latelight::render {

output::CameraMetadata describeCamera(const scene::Camera& camera, const scene::Scene& scene, const Settings& s) {
  const shared::View view = makeView(camera, s.width, s.height);
  output::CameraMetadata m;
  m.name = camera.name;
  const double halfWidth = s.width * 0.5, halfHeight = s.height * 0.5;
  const shared::Projection& p = view.projection;
  m.intrinsics = {p.H * halfWidth, 0, halfWidth * (1 + p.X), 0, p.V * halfHeight, halfHeight * (1 - p.Z), 0, 0, 1};
  m.cameraToWorld = openCvPose(camera, scene, s.axes == Axes::ZUp);
  m.orthographic = camera.orthographic;
  m.nearClip = camera.nearClip;
  m.farClip = camera.farClip;
  if (const ThinLens thin = thinLensOf(camera, s, scene); thin.radius > 0) {
    m.apertureRadius = thin.radius;
    m.focusDistance = thin.focus;
  }
  if (!bendsRays(camera)) return m;
  const scene::Lens lens = scene::scaledTo(*camera.lens, s.width, s.height);
  m.intrinsics = {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1};
  m.lens = lens;
  m.nearClip = 0;
  m.farClip = std::numeric_limits<double>::infinity();
  return m;
}

namespace {

// Returns the settings that the picture depends on, as on the command line. The frames of outputs are stated
// separately.
std::map<std::string, std::string> describeSettings(const Settings& s, const std::string& environment,
                                                    const ExplicitOptions& given) {
  std::map<std::string, std::string> settings;
  for (const Option& option : options()) {
    const auto found = given.find(keyOf(option));
    const std::string& text = found != given.end()          ? found->second
                              : option.defaultValue.empty() ? option.without
                                                            : option.defaultValue;
    if (!text.empty()) settings[std::string(keyOf(option))] = text;
  }
  for (const char* elsewhere : {"axes", "normal-frame"}) settings.erase(elsewhere);
  // The raster that `auto` stands for here, and the layout that the camera's lens requires.
  settings["raster"] = nameOf(s.raster);
  if (settings.contains("layout")) settings["layout"] = s.layout->name;
  settings["hdri"] = environment.empty() ? "none" : environment;
  if (s.time) settings["time"] = fmt::format("{}", *s.time);  // of this frame, in a sequence
  return settings;
}

}  // namespace

output::Metadata describe(const scene::Scene& scene, const scene::Camera& camera, const std::string& environment,
                          const Settings& s, const ExplicitOptions& given) {
  output::Metadata m;
  m.scene = scene.name;
  m.source = scene.source;
  m.camera = describeCamera(camera, scene, s);
  m.axes = scene.yUp && s.axes == Axes::File ? "gltf" : "z-up";
  m.normalFrame = nameOf(s.normalFrame);
  m.exposure = exposureFactor(s);  // if metered, the frame's own factor replaces it
  m.metered = s.exposure.automatic && showsPicture(s);
  m.settings = describeSettings(s, environment, given);
  if (std::ranges::any_of(s.aovs, output::holdsIds)) m.ids = std::make_shared<output::IdManifest>(idManifest(scene));
  return m;
}

}  // namespace latelight::render
