// Fog in pixels with several samples. It is applied to each surface before the mean of the samples, because surfaces at
// different distances have different fog. Include after common.glsl.
#ifndef LATELIGHT_SURFACE_FOG_GLSL
#define LATELIGHT_SURFACE_FOG_GLSL
#include "render/glsl/fog.glsl"

// Returns the transmittance from a position (world) to the camera.
float transmittanceFrom(FrameConstants frame, View view, vec3 position) {
  if (frame.fog.density <= 0.0) return 1.0;
  return fogTransmittanceTo(frame.fog, view, view.worldToView * vec4(position, 1.0));
}

// Applies fog to a surface's radiance. `place`: the surface's position in the image, in pixels; `depth`: its device
// depth, which must not be the background's.
vec3 surfaceInFog(FrameConstants frame, View view, vec2 place, float depth, vec3 radiance) {
  if (frame.fog.density <= 0.0) return radiance;
  vec3 position =
      viewPositionAtDepth(view.projection, pixelToNdc(place, view.size), viewDepth(view.projection, depth));
  return applyFog(frame.fog, vec4(radiance, 1.0), fogTransmittanceTo(frame.fog, view, position)).rgb;
}
#endif
