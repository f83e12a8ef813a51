// The values that the layout `exact` would store for a surface, as the sources of data outputs. Include before the
// layout that the shader is compiled for.
#ifndef LATELIGHT_EXACT_TARGETS_GLSL
#define LATELIGHT_EXACT_TARGETS_GLSL

// Includes `exact` under its own names, because the shader's other layout may be `exact` as well.
#define GbufferTexel ExactTexel
#define packGbuffer packExact
#define unpackGbuffer unpackExact
#include "shared/gbuffer/exact.h"
#undef GbufferTexel
#undef packGbuffer
#undef unpackGbuffer
#undef LATELIGHT_SHARED_GBUFFER_EXACT_H

uvec4 exactBits(vec4 v) { return floatBitsToUint(v); }
uvec4 exactBits(uvec4 v) { return v; }

#define EXACT_COUNT(index, name, format, type, channels) +1
struct ExactTargets {
  uvec4 v[0 GBUFFER_TARGETS(EXACT_COUNT)];
};

ExactTargets noTargets() {
  ExactTargets targets;
  for (int i = 0; i < targets.v.length(); ++i) targets.v[i] = uvec4(0u);
  return targets;
}

ExactTargets exactTargets(Surface s) {
  GbufferContext anywhere;
  ExactTexel texel = packExact(s, anywhere);
  ExactTargets targets;
#define EXACT_BITS(index, name, format, type, channels) targets.v[index] = exactBits(texel.name);
  GBUFFER_TARGETS(EXACT_BITS)
  return targets;
}

#undef GBUFFER_KEEPS_FLAGS
#undef GBUFFER_DESCRIPTION
#undef GBUFFER_FIXED_NORMAL
#undef GBUFFER_FIXED_POSITION
#undef GBUFFER_TARGETS

#endif
