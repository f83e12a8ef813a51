// Reading the G-buffer of the layout this shader is compiled for: set 0, bindings 0... in the order of the layout's
// targets, then depth, the light accumulation target, the counts of lights, and ambient occlusion. All are arrays with a
// layer a view.
#ifndef LATELIGHT_GBUFFER_READ_GLSL
#define LATELIGHT_GBUFFER_READ_GLSL
#include "gbuffer_layout.h"
#include "render/glsl/setup.glsl"

#define GBUFFER_SAMPLER_vec4 sampler2DArray
#define GBUFFER_SAMPLER_uint usampler2DArray
#define GBUFFER_SAMPLER_uvec2 usampler2DArray
#define GBUFFER_SAMPLER_uvec4 usampler2DArray
#define INPUT(index, name, format, type, channels) \
  layout(set = 0, binding = index) uniform GBUFFER_SAMPLER_##type gbuffer_##name;
GBUFFER_TARGETS(INPUT)
#define COUNT(index, name, format, type, channels) +1
const int kGbufferTargets = 0 GBUFFER_TARGETS(COUNT);
layout(set = 0, binding = 0 GBUFFER_TARGETS(COUNT)) uniform sampler2DArray gbufferDepth;
#ifdef GBUFFER_SAMPLED_ONLY  // before the include: for fragment shaders, which may lack storage images
#define GBUFFER_BINDINGS (1 GBUFFER_TARGETS(COUNT))  // the first binding after them
#else
layout(set = 0, binding = 1 GBUFFER_TARGETS(COUNT), rgba16f) uniform image2DArray lightTarget;
layout(set = 0, binding = 2 GBUFFER_TARGETS(COUNT), rgba32f) uniform writeonly image2DArray lightCounts;
#define GBUFFER_BINDINGS (3 GBUFFER_TARGETS(COUNT))
#endif

// The Surface at a pixel of a view. Its depth must not be the background's (0).
Surface readSurface(View view, ivec3 pixel, float depth, float ao) {
  GbufferContext context;
  context.view = view;
  context.pixel = vec2(pixel.xy) + 0.5;
  context.depth = depth;
  context.ao = ao;
  context.normalEncoding = kNormalEncoding;
  context.normalSpace = kNormalSpace;
  context.positionMethod = kPositionMethod;
  GbufferTexel texel;
#define FETCH_TARGET(index, name, format, type, channels) texel.name = type(texelFetch(gbuffer_##name, pixel, 0));
  GBUFFER_TARGETS(FETCH_TARGET)
  return unpackGbuffer(texel, context);
}
#endif
