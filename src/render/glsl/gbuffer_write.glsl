// Conversion of a Surface to the G-buffer values of the layout for which the shader is compiled, for all rasters.
#ifndef LATELIGHT_GBUFFER_WRITE_GLSL
#define LATELIGHT_GBUFFER_WRITE_GLSL
#include "render/glsl/setup.glsl"
#include "gbuffer_layout.h"
#include "render/glsl/gbuffer_context.glsl"

const float kShadedSeparately = -1.0;

// Returns the value of the light accumulation target: emitted radiance, and ambient occlusion or, for layered
// materials, the marker kShadedSeparately; render/layered lights those.
vec4 emittedLight(FrameConstants frame, Surface s) {
  bool layered = (s.flags & kSurfaceLayered) != 0u;
  return vec4(min(emittedRadiance(s) * frame.exposure, vec3(65504.0)), layered ? kShadedSeparately : s.ao);
}

// Returns the surface as the layout stores it. Without flags, unlit surfaces are stored as surfaces that reflect
// nothing.
Surface storedSurface(Surface s) {
#ifndef GBUFFER_KEEPS_FLAGS
  s = litSurface(s);
#endif
  return s;
}

#endif
