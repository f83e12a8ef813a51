// The outputs of shadow.frag and shadow_masked.frag. Include after varyings.glsl with ShadowDraw.
#include "render/glsl/setup.glsl"
#include "shared/shadow.h"

layout(location = 0) out vec4 packedDepth;  // for formats that are not depth formats

void writeShadow() {
  float depth = 2.0 * gl_FragCoord.z / gl_FragCoord.w;
  float bias = shadowCasterBias(dFdx(depth), dFdy(depth), more.unit / gl_FragCoord.w, kShadowFilter);
  depth = clamp(depth + bias, 0.0, kShadowFarthest);
  gl_FragDepth = depth;
  packedDepth = kShadowFormat == kShadowRgba8 ? packDepth(depth) : packDepthClassic(depth);
}
