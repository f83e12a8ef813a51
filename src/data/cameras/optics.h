// Camera intrinsics: reads the projection of a job's camera, which is independent of its pose.
#pragma once

#include "data/cameras/shot.h"
#include "data/spec.h"

namespace latelight::data {

struct Optics {
  scene::Camera camera;
  uint32_t width = 0, height = 0;  // in pixels; 0: the job's size
  // The minimum angle from the axis to the picture's edge, in radians. A cone of this half angle fits in the picture. 0
  // for panoramas.
  double halfAngle = 0;
};

// Reads the keys "fov", "K", "model", "distortion", "size", "pixelCenter", "aperture" and "focusDistance". The default
// is a field of view of 40 degrees. K is in pixels of "size", or of `job` if there is no "size".
Optics readOptics(Spec& spec, PictureSize job);
float readFov(Spec& spec);                             // reads only "fov", and returns radians
void readAperture(Spec& spec, scene::Camera& camera);  // reads only "aperture" and "focusDistance"
bool hasOptics(Spec& spec);                            // true if one of these keys is present

// Converts a lens to a camera. A pinhole with square pixels becomes a field of view and a principal point; all other
// lenses remain lenses.
Optics opticsOf(const scene::Lens& lens, uint32_t width, uint32_t height);

// Reads "size", width and height in pixels; returns `normal` if it is missing.
PictureSize readSize(Spec& spec, PictureSize normal = {});

}  // namespace latelight::data
