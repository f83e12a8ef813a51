// The ray of a pixel, as a function of the view: from its projection, or where a lens bends rays, from the table of
// render/lens/lens_rays.h. After common.glsl.
#ifndef LATELIGHT_PIXEL_RAY_GLSL
#define LATELIGHT_PIXEL_RAY_GLSL

layout(constant_id = 14) const uint kLens = 0u;  // FrameConfig::lens

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LensRayRef { LensRay v[]; };

LensRay lensRay(FrameConstants frame, View view, ivec2 pixel) {
  return LensRayRef(frame.rays).v[(pixel.y + 1) * int(view.size.x) + pixel.x];
}

// In view space. Times depth it is a position: through a pinhole it is 1 m deep, through a lens 1 m long. 0: the lens
// sees nothing there.
vec3 pixelRay(FrameConstants frame, View view, vec2 place) {
  if (kLens != 0u) return lensRay(frame, view, ivec2(place)).direction;
  return viewRay(view.projection, pixelToNdc(place, view.size));
}

// The way from a pixel's ray to that of a neighbour; false where it has none.
bool stepBetween(FrameConstants frame, View view, ivec2 from, ivec2 to, out vec3 way) {
  way = vec3(0.0);
  if (to.x < 0 || to.x >= int(view.size.x)) return false;
  vec3 other = lensRay(frame, view, to).direction;
  if (other == vec3(0.0)) return false;
  way = other - lensRay(frame, view, from).direction;
  return true;
}

// What a lens's ray grows by a pixel in a direction of the picture: the shorter of the steps to the next pixel and from
// the last one, since neighbours in the picture of a cube map or of the whole sphere may look elsewhere.
vec3 lensStep(FrameConstants frame, View view, ivec2 pixel, ivec2 direction) {
  vec3 onward, back;
  bool next = stepBetween(frame, view, pixel, pixel + direction, onward);
  bool last = stepBetween(frame, view, pixel, pixel - direction, back);
  bool takesLast = last && (!next || dot(back, back) < dot(onward, onward));
  return takesLast ? -back : onward;
}

#endif
