// The scene's state at the time that a picture shows.
#pragma once

#include <vector>

#include "render/deform/deformer.h"
#include "render/exposure/camera_motion.h"
#include "render/gpu_scene/worlds.h"
#include "scene/scene.h"

namespace latelight::render {

// The poses and cameras at that time, and in the previous and the next frame. By default the scene is at rest, and
// cameras are static.
struct SceneState {
  Poses poses;
  std::vector<scene::Camera> previousCameras, nextCameras;  // one per camera, or empty
  // The group of each of the scene's instances, by index, from 1 to 65535. A camera with a group renders only that
  // group's instances. Instances beyond the end of the list, or with group 0, are in no group.
  std::vector<uint32_t> groups;
  // Worlds, of which each camera shows one (Camera::world).
  WorldStates worlds;
  // This frame follows the frame submitted last, so temporal anti-aliasing and the temporal filter of indirect light
  // continue from it.
  bool continues = false;
  SceneMotion motion{};  // for --shutter and --readout
  // Exposure times and readouts in seconds, one per camera, in place of those of the settings. Empty: the settings'.
  std::vector<double> shutters, readouts;
  // EV, one per camera, in place of Settings::exposure.ev. Empty: the settings'.
  std::vector<double> exposures;
};

}  // namespace latelight::render
