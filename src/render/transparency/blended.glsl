// Forward shading of a fragment of a blended surface.
#extension GL_GOOGLE_include_directive : require
#include "render/visibility/varyings.glsl"
#include "render/visibility/surface_fragment.glsl"
#define PARTIAL_SUBGROUPS
#include "render/transparency/blended_light.glsl"

vec4 blendedFragment(FrameConstants frame) {
  return blendedColor(frame, push.view, drawMaterial(), fragmentPoint(), gl_FragCoord.xy, true);
}
