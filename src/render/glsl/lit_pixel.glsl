// The common part of the deferred lighting shaders: reads the surfaces of a pixel from the G-buffer, adds environment
// and emitted light, and writes the light accumulation target. A shader defines lightsAt(), which every invocation of
// the workgroup calls, and calls lightPixel() once for ownPixel().
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/gbuffer_write.glsl"
#include "render/glsl/environment.glsl"
#include "render/glsl/area_lights.glsl"
#include "render/glsl/pixel_group.glsl"
#include "render/glsl/uniform_loads.glsl"
#ifdef MULTISAMPLED
#include "render/glsl/redistribute.glsl"
#include "render/glsl/surface_fog.glsl"
#endif

// One surface of a pixel. With MULTISAMPLED, a pixel may have several.
struct LitPixel {
  ivec3 place;     // pixel and view
  uint samples;    // that show the surface
  bool lit;        // there is a surface
  bool shadedSeparately;  // render/layered lights it; treated as if there were no surface
  float depth;     // device depth
  Surface s;
  vec3 toEye;
  vec3 emitted;   // including exposure
  vec3 radiance;  // from the environment and area lights
};

// Returns the radiance that lights send from the surface to the eye, before exposure. `p.lit` is false for invocations
// without a surface.
vec3 lightsAt(FrameConstants frame, View view, LitPixel p);

// 1: some materials are layered.
layout(constant_id = kSomeShadedSeparatelyConstant) const uint kSomeShadedSeparately = 0u;

// Returns the light accumulation target's value from the geometry pass, for the surface that these samples show.
#ifdef GBUFFER_NO_TARGETS
vec4 accumulatedLight(ivec3 place, uint samples) { return vec4(0.0); }
#elif defined(MULTISAMPLED)
vec4 accumulatedLight(ivec3 place, uint samples) {
  return fetchSample(lightOfSamples, place, max(findLSB(samples), 0));
}
#else
vec4 accumulatedLight(ivec3 place, uint samples) { return imageLoad(lightTarget, place); }
#endif

LitPixel readPixel(FrameConstants frame, View view, ivec3 place, uint samples) {
  LitPixel p;
  p.place = place;
  p.samples = samples;
#ifdef MULTISAMPLED
  p.depth = samples != 0u ? depthOfSamples(gbufferDepth, place, samples) : 0.0;
#else
  p.depth = samples != 0u ? texelFetch(gbufferDepth, place, 0).r : 0.0;
#endif
  p.lit = p.depth != 0.0;
  p.shadedSeparately = false;
  p.s = emptySurface();
  p.toEye = vec3(0.0, 0.0, 1.0);
  p.emitted = vec3(0.0);
  p.radiance = vec3(0.0);
  vec4 accumulated = p.lit ? accumulatedLight(place, samples) : vec4(0.0);
  // Layered surfaces need no further reads, except to count their lights.
  if (kSomeShadedSeparately != 0u && kCountLights == 0u) p.shadedSeparately = accumulated.a == kShadedSeparately;
  if (p.lit && !p.shadedSeparately) {
#ifdef MULTISAMPLED
    p.s = readSurface(view, place, samples, p.depth, accumulated.a);
#else
    p.s = readSurface(view, place, p.depth, accumulated.a);
#endif
#ifdef GBUFFER_NO_TARGETS
    accumulated = emittedLight(frame, p.s);
#endif
    p.s.ao *= visibleHemisphere(place);
    p.emitted = accumulated.rgb;
    p.s = litSurface(p.s);
    p.toEye = directionToEye(view, p.s.position);
    if (reflects(p.s)) {
      p.radiance = environmentLight(frame, p.s, p.toEye);
      prepareForLights(p.s, p.toEye);
      p.radiance += areaLight(frame, p.s, p.toEye);
    }
  }
  return p;
}

vec3 litRadiance(FrameConstants frame, LitPixel p, vec3 byLights) {
  return min(p.emitted + (p.radiance + byLights) * frame.exposure, vec3(65504.0));
}

// Skips the lights if nothing reflects them. render/layered lights layered materials.
vec3 lightsOn(FrameConstants frame, View view, LitPixel p) {
  p.lit = p.lit && (kCountLights != 0u || reflects(p.s));
  return lightsAt(frame, view, p);
}

// Stores the lights tested and used, or 0 for a pixel without a surface.
void writeCounts(ivec3 place, bool lit, vec4 counts) {
  if (kCountLights != 0u && all(lessThan(place.xy, imageSize(lightCounts).xy)))
    imageStore(lightCounts, place, lit ? counts : vec4(0.0));
}

#ifndef MULTISAMPLED
// Returns true if the pixel has a surface.
bool lightPixel(FrameConstants frame, ivec3 place) {
  View view = uniformView(frame, place.z);
  bool inside = all(lessThan(vec2(place.xy), view.size));
  LitPixel p = readPixel(frame, view, place, inside ? 1u : 0u);
  vec3 byLights = lightsOn(frame, view, p);
  if (inside && !p.shadedSeparately)
    imageStore(lightTarget, place, p.lit ? vec4(litRadiance(frame, p, byLights), 1.0) : vec4(0.0));
  return p.lit;
}
#else
// Every invocation lights its pixel's first surface. The remaining surfaces are redistributed to the subgroup's lanes.
shared vec3 itemRadiance[256];

// Adds the radiance that the lanes computed for this lane's pixel in a round. The sum has the order of the surfaces, so
// it does not depend on the rounds.
void addItemRadiance(inout vec3 radiance, uint round, uint items, vec3 lit) {
  uint first = round * lanesPresent;
  itemRadiance[itemBase + laneRank] = lit;
  subgroupSharedBarrier();
  for (uint i = max(firstItem, first); i < min(firstItem + items, first + lanesPresent); ++i)
    radiance += itemRadiance[itemBase + i - first];
  subgroupSharedBarrier();
}

// Fog before a surface that render/layered lights is part of the picture, too: that pass only attenuates its own light.
vec3 radianceInFog(FrameConstants frame, View view, LitPixel p, vec3 byLights) {
  vec3 lit = litRadiance(frame, p, byLights);
  return p.lit ? surfaceInFog(frame, view, vec2(p.place.xy) + sampleCentroid(p.samples), p.depth, lit) : lit;
}

bool lightPixel(FrameConstants frame, ivec3 place) {
  View view = uniformView(frame, place.z);
  bool inside = all(lessThan(vec2(place.xy), view.size));
  uvec2 shown = inside ? countSurfaces(pixelSurfaces, place) : uvec2(0u);
  uint more = max(shown.x, 1u) - 1u;
  redistribute(more, place.xy);
  vec3 radiance = vec3(0.0);
  LitPixel p;
  p.place = place;
  p.samples = shown.x != 0u ? surfaceSamples(pixelSurfaces, place, 0u) : 0u;
  uint rounds = 1u + itemRounds();
  for (uint round = 0u; round < rounds; ++round) {
    p = readPixel(frame, view, p.place, p.samples);
    vec3 lit = radianceInFog(frame, view, p, lightsOn(frame, view, p)) * (float(bitCount(p.samples)) / float(kSamples));
    if (round == 0u)
      radiance = lit;
    else
      addItemRadiance(radiance, round - 1u, more, lit);
    LaneItem next = laneItem(round);
    p.place = ivec3(next.pixel, place.z);
    p.samples = next.there ? surfaceSamples(pixelSurfaces, p.place, next.index + 1u) : 0u;
  }
  if (inside) imageStore(lightTarget, place, vec4(radiance, float(shown.y) / float(kSamples)));
  return shown.x != 0u;
}
#endif
