// The moment that a picture shows.
#pragma once

#include <vector>

#include "render/deform/deformer.h"
#include "scene/scene.h"

namespace latelight::render {

// Where everything is at that moment, and where it was and will be in the previous and the next frame. By default the
// scene is at rest, and cameras are static.
struct Moment {
  Poses poses;
  std::vector<scene::Camera> previousCameras, nextCameras;  // as many as there are cameras, or none
  // Of the scene's instances, by their numbers: what a camera of a group shows. From 1 to 65535; beyond the end, and
  // where it is 0, an instance is in none.
  std::vector<uint32_t> groups;
  // It is the frame after the one submitted last: temporal anti-aliasing continues from there.
  bool continues = false;
};

}  // namespace latelight::render
