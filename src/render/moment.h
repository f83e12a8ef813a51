// When a picture is made.
#pragma once

#include <vector>

#include "render/deform/deformer.h"
#include "scene/scene.h"

namespace latelight::render {

// Where everything is when a picture is made, and where it was and will be a frame before and after. As it is at first:
// the scene at rest, and cameras that stand.
struct Moment {
  Poses poses;
  std::vector<scene::Camera> previousCameras, nextCameras;  // as many as there are cameras, or none
  // It follows the one that was submitted last, by a frame: temporal anti-aliasing goes on from there.
  bool continues = false;
};

}  // namespace latelight::render
