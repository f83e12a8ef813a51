// Reads the G-buffer of the layout for which the shader is compiled. Set 0 holds the layout's targets in order from
// binding 0, then depth, the light accumulation target and the light counts, all as array images with one layer per
// view. With MULTISAMPLED, the multisampled light of the geometry pass and the pixels' surfaces stand between depth and
// the light accumulation target, which then has one sample per pixel. If the layout has no targets, surfaces are
// evaluated from the visibility buffer; the shader has the variant `visible` and calls bindSurfaces() first.
#ifndef LATELIGHT_GBUFFER_READ_GLSL
#define LATELIGHT_GBUFFER_READ_GLSL
#include "gbuffer_layout.h"
#include "render/glsl/multisample.glsl"
#include "render/glsl/setup.glsl"
#include "render/glsl/gbuffer_context.glsl"
#ifdef GBUFFER_NO_TARGETS
#include "render/visibility/compute/visible_surface.glsl"
#else
#include "render/visibility/compute/shown_push.h"
void bindSurfaces(uint64_t frame, VisibleSurfacePush push) {}
#endif

#define GBUFFER_SAMPLER_vec4 TARGET_SAMPLER
#define GBUFFER_SAMPLER_uint TARGET_USAMPLER
#define GBUFFER_SAMPLER_uvec2 TARGET_USAMPLER
#define GBUFFER_SAMPLER_uvec4 TARGET_USAMPLER
#define INPUT(index, name, format, type, channels) \
  layout(set = 0, binding = index) uniform GBUFFER_SAMPLER_##type gbuffer_##name;
GBUFFER_TARGETS(INPUT)
#define COUNT(index, name, format, type, channels) +1
const int kGbufferTargets = 0 GBUFFER_TARGETS(COUNT);
layout(set = 0, binding = 0 GBUFFER_TARGETS(COUNT)) uniform TARGET_SAMPLER gbufferDepth;
#ifndef MULTISAMPLED
#define GBUFFER_INPUTS (1 GBUFFER_TARGETS(COUNT))
#elif defined(GBUFFER_NO_TARGETS)
layout(set = 0, binding = 1) uniform usampler2DArray pixelSurfaces;
#define GBUFFER_INPUTS 2
#else
layout(set = 0, binding = 1 GBUFFER_TARGETS(COUNT)) uniform TARGET_SAMPLER lightOfSamples;
#ifdef GBUFFER_NO_SURFACES  // define before the include: for passes that compute the surfaces
#define GBUFFER_INPUTS (2 GBUFFER_TARGETS(COUNT))
#else
layout(set = 0, binding = 2 GBUFFER_TARGETS(COUNT)) uniform usampler2DArray pixelSurfaces;
#define GBUFFER_INPUTS (3 GBUFFER_TARGETS(COUNT))
#endif
#endif
#ifdef GBUFFER_SAMPLED_ONLY  // define before the include: for fragment shaders, which may lack storage images
#define GBUFFER_BINDINGS GBUFFER_INPUTS  // the first binding after the inputs
#else
layout(set = 0, binding = GBUFFER_INPUTS, rgba16f) uniform image2DArray lightTarget;
layout(set = 0, binding = 1 + GBUFFER_INPUTS, rgba32f) uniform writeonly image2DArray lightCounts;
#define GBUFFER_BINDINGS (2 + GBUFFER_INPUTS)
#endif

#ifndef GBUFFER_NO_TARGETS
GbufferTexel readTexel(ivec3 pixel, int index) {
  GbufferTexel texel;
#define FETCH_TARGET(number, name, format, type, channels) texel.name = type(fetchSample(gbuffer_##name, pixel, index));
  GBUFFER_TARGETS(FETCH_TARGET)
  return texel;
}

// Returns the Surface of a texel at a position in the image. `depth` must not be the background's (0).
Surface unpackSurface(View view, vec2 place, GbufferTexel texel, float depth, float ao) {
  GbufferContext context = gbufferContext(view, place);
  context.depth = depth;
  context.ao = ao;
  return unpackGbuffer(texel, context);
}

#endif

// Returns the Surface at a pixel of a view; with MULTISAMPLED, the one that these samples show.
#if defined(GBUFFER_NO_TARGETS) && defined(MULTISAMPLED)
Surface readSurface(View view, ivec3 pixel, uint samples, float depth, float ao) {
  return visibleSurface(view, pixel, samples);
}
#elif defined(GBUFFER_NO_TARGETS)
Surface readSurface(View view, ivec3 pixel, float depth, float ao) { return visibleSurface(view, pixel, 1u); }
#elif defined(MULTISAMPLED)
Surface readSurface(View view, ivec3 pixel, uint samples, float depth, float ao) {
  vec2 place = vec2(pixel.xy) + sampleCentroid(samples);
  Surface s = unpackSurface(view, place, readTexel(pixel, max(findLSB(samples), 0)), depth, ao);
  GbufferContext context = gbufferContext(view, place);
  context.depth = depth;
  s.position = positionFromDepth(context);  // layouts may store the first sample's
  return s;
}
#else
Surface readSurface(View view, ivec3 pixel, float depth, float ao) {
  return unpackSurface(view, vec2(pixel.xy) + 0.5, readTexel(pixel, 0), depth, ao);
}
#endif
#endif
