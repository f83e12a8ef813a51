// The ray of a pixel: from the view's projection, or for a lens from the table of render/lens/lens_rays.h. Include
// after common.glsl.
#ifndef LATELIGHT_PIXEL_RAY_GLSL
#define LATELIGHT_PIXEL_RAY_GLSL

layout(constant_id = kLensConstant) const uint kLens = 0u;  // FrameConfig::lens

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LensRayRef { LensRay v[]; };

LensRay lensRay(FrameConstants frame, View view, ivec2 pixel) {
  return LensRayRef(frame.rays).v[(pixel.y + 1) * int(view.size.x) + pixel.x];
}

// Returns the ray in view space. Multiplied by depth it is a position: for a pinhole it has depth 1 m, for a lens
// length 1 m. It is 0 if the lens sees nothing at this pixel.
vec3 pixelRay(FrameConstants frame, View view, vec2 place) {
  if (kLens != 0u) return lensRay(frame, view, ivec2(place)).direction;
  return viewRay(view.projection, pixelToNdc(place, view.size));
}

// Returns the difference to a neighbor's ray in `way`; false if the neighbor has no ray.
bool stepBetween(FrameConstants frame, View view, ivec2 from, ivec2 to, out vec3 way) {
  way = vec3(0.0);
  if (to.x < 0 || to.x >= int(view.size.x)) return false;
  vec3 other = lensRay(frame, view, to).direction;
  if (other == vec3(0.0)) return false;
  way = other - lensRay(frame, view, from).direction;
  return true;
}

// Returns the derivative of a lens ray per pixel in a direction of the image: the shorter of the forward and backward
// differences, because neighbors in cube maps and spherical images may look in different directions.
vec3 lensStep(FrameConstants frame, View view, ivec2 pixel, ivec2 direction) {
  vec3 onward, back;
  bool next = stepBetween(frame, view, pixel, pixel + direction, onward);
  bool last = stepBetween(frame, view, pixel, pixel - direction, back);
  bool takesLast = last && (!next || dot(back, back) < dot(onward, onward));
  return takesLast ? -back : onward;
}

#endif
