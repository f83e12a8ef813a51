// Projects directions through the lens models of scene/lens.h to pixels, on the device and in single precision.
#ifndef LATELIGHT_SHARED_LENS_PROJECTION_H
#define LATELIGHT_SHARED_LENS_PROJECTION_H

#include "shared/lang.h"

SH_BEGIN

// The values of scene::LensModel.
SH_CONST uint kLensPinhole = 0u;
SH_CONST uint kLensOpenCv = 1u;
SH_CONST uint kLensFisheye = 2u;
SH_CONST uint kLensEquirectangular = 3u;
SH_CONST uint kLensCubeMap = 4u;
SH_CONST uint kLensFTheta = 5u;

// A lens that is calibrated for images of width x height pixels.
struct LensCalibration {
  uint model;
  float width, height;
  float fx, fy, cx, cy;
  float limit;  // LensProjection's first turning point; at most 1e9
  vec4 low;     // the distortion's coefficients 0 to 3
  vec4 high;    // 4 to 7
};

struct LensPoint {
  vec2 pixel;  // y down
  uint known;  // 0: the lens does not project the direction
};

SH_FUNC vec2 openCvDistorted(LensCalibration lens, vec2 p) {
  float r2 = dot(p, p);
  float above = 1.0f + r2 * (lens.low.x + r2 * (lens.low.y + r2 * lens.high.x));
  float below = 1.0f + r2 * (lens.high.y + r2 * (lens.high.z + r2 * lens.high.w));
  float scale = above / below, p1 = lens.low.z, p2 = lens.low.w;
  return vec2(p.x * scale + 2.0f * p1 * p.x * p.y + p2 * (r2 + 2.0f * p.x * p.x),
              p.y * scale + p1 * (r2 + 2.0f * p.y * p.y) + 2.0f * p2 * p.x * p.y);
}

SH_FUNC float fisheyeRadius(LensCalibration lens, float theta) {
  float t = theta * theta;
  return theta * (1.0f + t * (lens.low.x + t * (lens.low.y + t * (lens.low.z + t * lens.low.w))));
}

SH_FUNC float fthetaAngle(LensCalibration lens, float r) {
  return lens.low.x + r * (lens.low.y + r * (lens.low.z + r * (lens.low.w + r * (lens.high.x + r * lens.high.y))));
}

SH_FUNC float fthetaSlope(LensCalibration lens, float r) {
  return lens.low.y +
         r * (2.0f * lens.low.z + r * (3.0f * lens.low.w + r * (4.0f * lens.high.x + r * 5.0f * lens.high.y)));
}

// The distance at which the f-theta polynomial, which increases up to the limit, reaches an angle: by Newton's method
// within brackets that bisection narrows.
SH_FUNC float fthetaRadius(LensCalibration lens, float theta) {
  float low = 0.0f, high = lens.limit;
  float r = min(max((theta - lens.low.x) / lens.low.y, 0.0f), high);
  for (int i = 0; i < 32; ++i) {
    float excess = fthetaAngle(lens, r) - theta;
    if (excess > 0.0f)
      high = r;
    else
      low = r;
    float next = r - excess / fthetaSlope(lens, r);
    bool inside = next >= low && next <= high;
    r = inside ? next : 0.5f * (low + high);
  }
  return r;
}

// The face of a cube map whose axis is nearest to a direction, and the position on it from -1 to 1; camera frame.
SH_FUNC vec3 cubeMapPlace(vec3 v) {
  float x = abs(v.x), y = abs(v.y), z = abs(v.z);
  if (x >= y && x >= z) return vec3(v.x >= 0.0f ? 0.0f : 1.0f, (v.x >= 0.0f ? -v.z : v.z) / x, v.y / x);
  if (y >= z) return vec3(v.y >= 0.0f ? 2.0f : 3.0f, v.x / y, (v.y >= 0.0f ? -v.z : v.z) / y);
  return vec3(v.z >= 0.0f ? 4.0f : 5.0f, (v.z >= 0.0f ? v.x : -v.x) / z, v.y / z);
}

SH_FUNC LensPoint calibratedPoint(LensCalibration lens, vec2 p, bool known) {
  LensPoint projected;
  projected.pixel = vec2(lens.fx * p.x + lens.cx, lens.fy * p.y + lens.cy);
  projected.known = known ? 1u : 0u;
  return projected;
}

// `v`: in the camera's frame (X right, Y down, Z forward), of any length.
SH_FUNC LensPoint projectThroughLens(LensCalibration lens, vec3 v) {
  LensPoint projected;
  projected.known = 1u;
  if (lens.model == kLensEquirectangular) {
    projected.pixel = vec2((0.5f + atan2(v.x, v.z) / (2.0f * kPi)) * lens.width,
                           (0.5f + atan2(v.y, length(vec2(v.x, v.z))) * kInvPi) * lens.height);
    return projected;
  }
  if (lens.model == kLensCubeMap) {
    vec3 place = cubeMapPlace(v);
    projected.pixel =
        vec2((place.x + 0.5f + 0.5f * place.y) * lens.width / 6.0f, (0.5f + 0.5f * place.z) * lens.height);
    return projected;
  }
  if (lens.model == kLensPinhole || lens.model == kLensOpenCv) {
    vec2 p = vec2(v.x / v.z, v.y / v.z);
    if (lens.model == kLensPinhole) return calibratedPoint(lens, p, v.z > 0.0f);
    return calibratedPoint(lens, openCvDistorted(lens, p), v.z > 0.0f && dot(p, p) < lens.limit);
  }
  float across = length(vec2(v.x, v.y)), theta = atan2(across, v.z);
  bool fisheye = lens.model == kLensFisheye;
  float end = fisheye ? lens.limit : fthetaAngle(lens, lens.limit);
  bool known = theta <= end && (fisheye || theta >= lens.low.x);
  float radius = fisheye ? fisheyeRadius(lens, theta) : fthetaRadius(lens, theta);
  float scale = across > 0.0f ? radius / across : 0.0f;
  return calibratedPoint(lens, vec2(v.x * scale, v.y * scale), known);
}

// Motion from one pixel to another. It is 0 if the lens does not project either. In an equirectangular image, it takes
// the shorter way around.
SH_FUNC vec2 motionThroughLens(LensCalibration lens, LensPoint from, LensPoint to) {
  float x = to.pixel.x - from.pixel.x, y = to.pixel.y - from.pixel.y;
  if (lens.model == kLensEquirectangular) x -= lens.width * floor(x / lens.width + 0.5f);
  bool known = from.known != 0u && to.known != 0u && abs(x) < 3.0e38f && abs(y) < 3.0e38f;
  return vec2(known ? x : 0.0f, known ? y : 0.0f);
}

SH_END

#endif
