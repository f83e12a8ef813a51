#include "data/batch/camera_checks.h"

#include "render/exposure/camera_motion.h"
#include "render/exposure/check.h"
#include "render/frame/view.h"
#include "render/outputs/outputs.h"
#include "render/submit/describe.h"
#include "render/submit/lens_settings.h"
#include "render/submit/scene_checks.h"

namespace latelight::data {

namespace {

// Returns true if the scene or the camera moves while an image is exposed.
bool moves(const CameraTimeline& cameras, size_t i, const render::Settings& settings) {
  const scene::Camera& now = cameras.camera(i).camera;
  const auto previous = cameras.previous(i), next = cameras.next(i);
  const render::CameraMotion motion({now}, {previous ? previous->camera : now}, {next ? next->camera : now},
                                    {.poseAt = cameras.posesNear(i)}, settings);
  return motion.movesScene() || motion.movesCameras();
}

// The renderer makes the same checks, but only when it renders a frame.
void checkRendering(const CameraTimeline& cameras, size_t i, const render::Settings& settings,
                    const output::CameraMetadata& described) {
  const scene::Camera& camera = cameras.camera(i).camera;
  if (camera.lens) scene::checkLens(*camera.lens, settings.width, settings.height);
  if (render::bendsRays(camera)) render::lensSettings(settings);
  const bool isMoving = (settings.shutter > 0 || settings.readout != 0) && moves(cameras, i, settings);
  const bool blurs = (settings.shutter > 0 && isMoving) || described.apertureRadius > 0;
  render::checkExposure(
      settings, {.exposes = render::showsPicture(settings) && blurs, .byRows = settings.readout != 0 && isMoving});
}

}  // namespace

// The renderer makes the same checks, but only when it renders a frame. Variations neither remove lights nor name those
// that they add.
void checkScene(const Job& job, const LoadedScene& loaded) {
  render::checkBackground(job.settings, loaded.hasEnvironmentInAllVariations());
  render::checkShadowLightsOf(loaded.scene(), job.settings);
}

void checkCameras(const Job& job, const LoadedScene& loaded,
                  const std::function<std::string(const std::string& camera)>& frameName) {
  const CameraTimeline& cameras = loaded.cameras();
  DataFrame first;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const JobCamera& camera = cameras.camera(i);
    render::Settings settings = cameras.settingsOf(i);
    settings.width = camera.width;
    settings.height = camera.height;
    DataFrame frame{.name = frameName(camera.name), .camera = static_cast<uint32_t>(i), .exposure = camera.exposure};
    frame.picture.width = camera.width;
    frame.picture.height = camera.height;
    frame.metadata.camera = render::describeCamera(camera.camera, loaded.scene(), settings);
    frame.metadata.camera.name = camera.name;
    checkRendering(cameras, i, settings, frame.metadata.camera);
    for (const JobFormat& use : job.formats) {
      use.format->check(frame);
      if (i > 0) use.format->checkTogether(first, frame);
    }
    if (i == 0) first = std::move(frame);
  }
}

}  // namespace latelight::data
