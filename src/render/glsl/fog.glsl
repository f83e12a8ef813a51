// Fog between the camera and a surface.
#ifndef LATELIGHT_FOG_GLSL
#define LATELIGHT_FOG_GLSL
#include "shared/fog.h"

// Returns the transmittance from a view-space position to the camera: to its eye, or to its plane if it is
// orthographic.
float fogTransmittanceTo(Fog fog, View view, vec3 position) {
  bool perspective = view.projection.kind == kPerspective;
  vec3 start = perspective ? vec3(0.0) : vec3(position.x, 0.0, position.z);
  vec3 ray = position - start;
  float distance = perspective ? length(ray) : max(ray.y, 0.0);
  vec3 direction = view.viewToWorld * vec4(perspective ? ray / max(distance, 1.0e-30) : vec3(0.0, 1.0, 0.0), 0.0);
  return fogTransmittance(fogOpticalDepth(fog, view.viewToWorld * vec4(start, 1.0), direction, distance));
}

// Returns the transmittance of a pixel's ray, in view space, that hits nothing.
float fogTransmittanceBeyond(Fog fog, View view, vec2 ndc, vec3 ray) {
  bool perspective = view.projection.kind == kPerspective;
  vec3 start = perspective ? vec3(0.0) : viewPositionAtDepth(view.projection, ndc, 0.0);
  vec3 direction = view.viewToWorld * vec4(normalize(ray), 0.0);
  return fogTransmittance(fogOpticalDepthToInfinity(fog, view.viewToWorld * vec4(start, 1.0), direction));
}
#endif
