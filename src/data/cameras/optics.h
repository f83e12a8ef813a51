// How a camera sees: the part of a job's camera that is not its place.
#pragma once

#include "data/cameras/shot.h"
#include "data/spec.h"

namespace latelight::data {

struct Optics {
  scene::Camera camera;
  uint32_t width = 0, height = 0;  // pixels; 0: the job's
  // The least angle from the axis to the picture's edge, radians: what fits in it fits in the picture. 0: all around.
  double halfAngle = 0;
};

// The keys "fov", "K", "model", "distortion", "size" and "pixelCentre"; a field of view of 40 degrees where there is
// none of them. `job`: the size that K counts in where there is no "size".
Optics readOptics(Spec& spec, PictureSize job);
bool saysOptics(Spec& spec);  // whether it has one of them

// Square pixels without distortion are a field of view and a principal point, all else stays a lens.
Optics opticsOf(const scene::Lens& lens, uint32_t width, uint32_t height);

// "size": width and height in pixels; `normal` where it is missing.
PictureSize readSize(Spec& spec, PictureSize normal = {});

}  // namespace latelight::data
