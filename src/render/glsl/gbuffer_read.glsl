// Reading the G-buffer of the layout this shader is compiled for: set 0, bindings 0... in the order of the layout's
// targets, then depth, then the light accumulation target. All are arrays with a layer a view.
#include "gbuffer_layout.h"

#define GBUFFER_SAMPLER_vec4 sampler2DArray
#define GBUFFER_SAMPLER_uvec2 usampler2DArray
#define GBUFFER_SAMPLER_uvec4 usampler2DArray
#define INPUT(index, name, format, type, channels) \
  layout(set = 0, binding = index) uniform GBUFFER_SAMPLER_##type gbuffer_##name;
GBUFFER_TARGETS(INPUT)
#define COUNT(index, name, format, type, channels) +1
const int kGbufferTargets = 0 GBUFFER_TARGETS(COUNT);
layout(set = 0, binding = 0 GBUFFER_TARGETS(COUNT)) uniform sampler2DArray gbufferDepth;
layout(set = 0, binding = 1 GBUFFER_TARGETS(COUNT), rgba16f) uniform image2DArray lightTarget;

// The Surface at a pixel of a view. Its depth must not be the background's (0).
Surface readSurface(View view, ivec3 pixel, float depth, float ao, uint normalEncoding) {
  GbufferContext context;
  context.view = view;
  context.pixel = vec2(pixel.xy) + 0.5;
  context.depth = depth;
  context.ao = ao;
  context.normalEncoding = normalEncoding;
  GbufferTexel texel;
#define FETCH_TARGET(index, name, format, type, channels) texel.name = type(texelFetch(gbuffer_##name, pixel, 0));
  GBUFFER_TARGETS(FETCH_TARGET)
  return unpackGbuffer(texel, context);
}
