// What the lighting shaders do around their lights: a pixel's surfaces and the environment's light on them, and the
// result. A shader defines lightsAt(), which every invocation of the workgroup comes to, and calls lightPixel() once.
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/environment.glsl"
#ifdef MULTISAMPLED
#include "render/glsl/lanes.glsl"
#endif

// One surface of a pixel: the only one, but where samples differ (MULTISAMPLED).
struct LitPixel {
  ivec3 place;   // and view
  uint samples;  // those that show it
  bool lit;      // a surface is there
  float depth;   // of the device
  Surface s;
  vec3 toEye;
  vec3 emitted;   // what the geometry pass left, exposure included
  vec3 radiance;  // by the environment
};

// Radiance that lights send from the surface to the eye, before exposure. `p.lit` is false for invocations without one.
vec3 lightsAt(FrameConstants frame, View view, LitPixel p);

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
  p.s = emptySurface();
  p.toEye = vec3(0.0, 0.0, 1.0);
  p.emitted = vec3(0.0);
  p.radiance = vec3(0.0);
  if (p.lit) {
#ifdef MULTISAMPLED
    vec4 accumulated = texelFetch(lightOfSamples, place, findLSB(samples));
    p.s = readSurface(view, place, samples, p.depth, accumulated.a);
#else
    vec4 accumulated = imageLoad(lightTarget, place);
    p.s = readSurface(view, place, p.depth, accumulated.a);
#endif
    p.s.ao *= visibleHemisphere(place);
    p.emitted = accumulated.rgb;
    if ((p.s.flags & kSurfaceUnlit) != 0u) p.s = withoutReflection(p.s);
    p.toEye = directionToEye(view, p.s.position);
    p.radiance = environmentLight(frame, p.s, p.toEye);
    prepareForLights(p.s, p.toEye);
  }
  return p;
}

vec3 litRadiance(FrameConstants frame, LitPixel p, vec3 byLights) {
  return min(p.emitted + (p.radiance + byLights) * frame.exposure, vec3(65504.0));
}

// Lights tested and used; those of a pixel without a surface are none.
void writeCounts(ivec3 place, bool lit, vec4 counts) {
  if (kCountLights != 0u && all(lessThan(place.xy, imageSize(lightCounts).xy)))
    imageStore(lightCounts, place, lit ? counts : vec4(0.0));
}

#ifndef MULTISAMPLED
// Returns whether a surface is there.
bool lightPixel(FrameConstants frame, ivec3 place) {
  View view = frameView(frame, place.z);
  bool inside = all(lessThan(vec2(place.xy), view.size));
  LitPixel p = readPixel(frame, view, place, inside ? 1u : 0u);
  vec3 byLights = lightsAt(frame, view, p);
  if (inside) imageStore(lightTarget, place, p.lit ? vec4(litRadiance(frame, p, byLights), 1.0) : vec4(0.0));
  return p.lit;
}
#else
// Every invocation lights its pixel's first surface. Few pixels have more; those of a subgroup are then dealt to all its
// lanes, so that a pixel at an edge does not make the lanes around it wait (as Lauritzen 2010, Deferred Rendering for
// Current and Future Rendering Pipelines, SIGGRAPH, packs such pixels of a tile: here without a barrier of the
// workgroup).
const uint kMostMore = 3u;  // surfaces beside the first
shared uint dealtPlaces[256u * kMostMore];
shared vec3 dealtRadiance[256u * kMostMore];

uint surfacesAt(ivec3 place, View view) {
  return all(lessThan(vec2(place.xy), view.size)) ? texelFetch(pixelSurfaces, place, 0).r : 0u;
}

bool lightPixel(FrameConstants frame, ivec3 place) {
  countLanes();
  View view = frameView(frame, place.z);
  uint surfaces = surfacesAt(place, view);
  uint more = max(surfaceCount(surfaces), 1u) - 1u;
  uint dealt = subgroupAdd(more);
  uint base = gl_SubgroupID * gl_SubgroupSize * kMostMore;
  uint own = base + subgroupExclusiveAdd(more);
  for (uint i = 0u; i < more; ++i) dealtPlaces[own + i] = uint(place.x) | uint(place.y) << 14u | (i + 1u) << 28u;
  subgroupMemoryBarrierShared();
  subgroupBarrier();

  vec3 radiance = vec3(0.0);
  LitPixel p;
  p.place = place;
  p.samples = surfaceSamples(surfaces, 0u);
  uint rounds = 1u + (dealt + lanesPresent - 1u) / lanesPresent;
  for (uint round = 0u; round < rounds; ++round) {
    p = readPixel(frame, view, p.place, p.samples);
    vec3 lit = litRadiance(frame, p, lightsAt(frame, view, p)) * (float(bitCount(p.samples)) / float(kSamples));
    uint item = (round - 1u) * lanesPresent + laneRank;
    if (round == 0u)
      radiance = lit;
    else if (item < dealt)
      dealtRadiance[base + item] = lit;
    uint next = round * lanesPresent + laneRank;
    uint packed = dealtPlaces[base + min(next, max(dealt, 1u) - 1u)];
    p.place = ivec3(packed & 0x3fffu, packed >> 14u & 0x3fffu, place.z);
    p.samples = next < dealt ? surfaceSamples(surfacesAt(p.place, view), packed >> 28u) : 0u;
  }
  subgroupMemoryBarrierShared();
  subgroupBarrier();
  for (uint i = 0u; i < more; ++i) radiance += dealtRadiance[own + i];
  if (all(lessThan(vec2(place.xy), view.size)))
    imageStore(lightTarget, place, vec4(radiance, float(bitCount(surfaces)) / float(kSamples)));
  return surfaces != 0u;
}
#endif
