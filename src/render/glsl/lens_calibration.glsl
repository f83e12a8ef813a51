// The lenses of a frame, by which shaders project points. Include after common.glsl.
#ifndef LATELIGHT_LENS_CALIBRATION_GLSL
#define LATELIGHT_LENS_CALIBRATION_GLSL
#include "shared/lens_projection.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LensCalibrationRef { LensCalibration v[]; };

// Returns the pixel that shows a direction in view space.
LensPoint projectFromView(LensCalibration lens, vec3 inView) {
  return projectThroughLens(lens, vec3(inView.x, -inView.z, inView.y));
}

#endif
