// Converts the options and cameras of a call to the settings and the scene's state of a request.
#pragma once

#include <latelight/latelight.h>

#include <cstdint>
#include <vector>

#include "base/memory.h"
#include "render/settings/settings.h"
#include "render/submit/raster_choice.h"
#include "render/submit/scene_state.h"
#include "render/submit/session.h"
#include "scene/scene.h"
#include "shared/types.h"
#include "vk/device.h"

namespace latelight {

// Throws Error(Usage) for invalid options. The raster may still be a choice of settingsFor().
render::Settings internalSettings(const Options& o);

// Throws Error(Usage) if an animation is chosen without a time.
void checkPlayback(const render::Settings& s);

render::RasterUse rasterUseOf(const Worlds& worlds);

// Returns checked settings with the raster that renders them.
render::Settings settingsFor(vk::Device& device, const Options& o, const scene::Scene& scene,
                             render::RasterUse use = render::RasterUse::Image);

// The host memory that a camera of a call requires until its picture is taken.
inline constexpr uint64_t kCameraBytes = 4 * sizeof(scene::Camera) + 3 * sizeof(shared::View);
// Claims the memory of this number of cameras. Throws Error(OutOfMemory) if it would exceed the limit.
MemoryClaim claimCameras(uint64_t cameras);

// Returns as many cameras as `count`, or none.
std::vector<scene::Camera> internalCameras(const std::vector<Camera>& cameras, const scene::Scene& scene, size_t count,
                                           render::CameraFit fit);

// Returns the state of the scene at the time of the options. `cameras`: their number.
render::SceneState internalState(const Options& o, const render::Settings& s, const scene::Scene& scene,
                                 size_t cameras);

// Return the camera's own value, or the usual one. They throw Error(Usage) if it is out of range.
double shutterOf(const Camera& camera, double usual);
double readoutOf(const Camera& camera, double usual);
double exposureOf(const Camera& camera, double usual);

// Writes the cameras' own exposures.
void setExposures(render::SceneState& moment, const std::vector<Camera>& cameras, const render::Settings& settings);

// Returns the settings of a single camera's picture.
render::Settings withExposure(render::Settings settings, const Camera& camera);

// Throws Error(Usage) if cameras of worlds have exposures of their own.
void rejectExposures(const std::vector<Camera>& cameras);

}  // namespace latelight
