#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible
// Adds the light of lights that cast shadows, and traces rays to them: one to a light without size, and several to the
// disk of a light with a radius. Inputs: the G-buffer, FrameConstants::shadowMaps (RayShadow) and the scene's BVHs.
// Output: lightTarget. The lighting technique has added all other light before.
//
// Spans of pixels are used for a single light only. A subgroup lists the pixels that face the light, and shades them
// when it has one per lane. Otherwise lanes without a ray would be idle.
#define ONE_SAMPLE
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/glsl/pixel_span.glsl"
#include "render/glsl/ray_samples.glsl"
#include "render/glsl/rays.glsl"
#include "render/glsl/subgroup_shared_barrier.glsl"
#include "render/shadow/ray_shadows_push.h"

layout(push_constant, scalar) uniform Push { RayShadowsPush push; };
#include "render/shadow/light_sums.glsl"

// 1: the surface is read again after the rays of a light, so that its material takes no registers during traversal.
layout(constant_id = kReadsSurfaceAgainConstant) const uint kReadsSurfaceAgain = 0u;

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RayShadowRef { RayShadow v[]; };

// Returns the ray from a surface to a point of a light: the center, moved by `offset` in units of the light's size.
Ray shadowRay(View view, Light light, RayShadow shadow, Surface s, vec3 toLight, vec2 offset) {
  Ray ray;
  ray.origin = s.position + s.normal * rayOffset(s.position, distance(s.position, view.eye));
  ray.originLow = vec3(0.0);
  mat3 axes = rayAxes(toLight);
  vec3 moved = (axes[0] * offset.x + axes[1] * offset.y) * shadow.lightSize;
  bool directional = lightIsDirectional(light.type);
  vec3 way = directional ? toLight + moved : light.position + moved - ray.origin;
  float away = length(way);
  ray.direction = way / away;
  ray.near = 0.0;
  // Geometry nearer to a light than its radius is the light's own body.
  ray.far = directional ? 3.0e38 : max(away - shadow.lightSize - rayOffset(light.position, away), 0.0);
  return ray;
}

// Returns the fraction of a light's disk that rays reach. The samples depend only on the surface's position.
float litByRays(FrameConstants frame, View view, Light light, RayShadow shadow, Surface s, vec3 toLight) {
  if (shadow.rays == 0u) return 1.0;
  vec2 start = raySeed(s.position);
  float lit = 0.0;
  uint i = 0u;
  do {  // tested at the end, here and below, because lavapipe would execute the body once more
    vec2 offset = shadow.lightSize == 0.0 ? vec2(0.0) : diskSample(raySample(start, i));
    lit += isBlocked(frame, shadowRay(view, light, shadow, s, toLight, offset)) ? 0.0 : 1.0;
  } while (++i < shadow.rays);
  return lit / float(shadow.rays);
}

RayShadow shadowOf(FrameConstants frame, int view, uint column) {
  return RayShadowRef(frame.shadowMaps).v[uint(view) * push.viewStride + column];
}
uint lightOf(FrameConstants frame, RayShadow shadow) {
  return min(shadow.light, max(frame.lightCount, 1u) - 1u);  // as triangleOfTile()
}
bool reaches(LightSample arriving, Surface s) {
  return arriving.attenuation * dot(s.normal, arriving.toLight) > 0.0;  // the factor of shadeLight()
}

// Returns `radiance` plus that of the lights of this pass.
vec3 lightsAt(FrameConstants frame, View view, LitPixel p, vec3 radiance) {
  uint i = push.first;
  do {
    RayShadow shadow = shadowOf(frame, p.place.z, i);
    uint index = lightOf(frame, shadow);
    Light light = frameLight(frame, index);
    LightSample arriving = sampleLight(light, p.s.position);
    bool reached = reaches(arriving, p.s);
    float lit = 0.0;
    if (shadow.light < frame.lightCount && reached)
      lit = litByRays(frame, view, light, shadow, p.s, arriving.toLight);
    if (lit > 0.0) {
      if (kReadsSurfaceAgain != 0u) p = readPixel(frame, frameView(frame, p.place.z), p.place, 1u);
      LightSample sent = sampleLight(frameLight(frame, index), p.s.position);
      radiance += shadeLight(surfaceBrdf(p.s, p.toEye, kShading), sent, kShading) * lit;
    }
  } while (++i < push.end);
  return radiance;
}

void lightSurface(FrameConstants frame, View view, LitPixel p) {
  addLight(frame, p.place, lightsAt(frame, view, p, lightBefore(p.place)));
}

bool isReflecting(View view, LitPixel p) {
  bool inside = all(lessThan(vec2(p.place.xy), view.size));
  return inside && p.lit && !p.shadedSeparately && reflects(p.s);
}

LitPixel readInside(FrameConstants frame, View view, ivec3 place) {
  return readPixel(frame, view, place, all(lessThan(vec2(place.xy), view.size)) ? 1u : 0u);
}

// --- spans -----------------------------------------------------------------------------------------------------------

shared uint listed[2u * kPixelGroupX * kPixelGroupY];  // pixels, x | y << 16: two per invocation
uint listBase;                                          // the subgroup's part of the list

bool facesLight(FrameConstants frame, View view, ivec3 place) {
  LitPixel p = readInside(frame, view, place);
  if (!isReflecting(view, p)) return false;
  RayShadow shadow = shadowOf(frame, place.z, push.first);
  LightSample arriving = sampleLight(frameLight(frame, lightOf(frame, shadow)), p.s.position);
  return shadow.light < frame.lightCount && reaches(arriving, p.s);
}

// Appends this lane's pixel to the subgroup's list if `wanted`. Returns the new length.
uint appended(ivec3 place, bool wanted, uint length) {
  uvec4 ballot = subgroupBallot(wanted);
  uint at = listBase + length + subgroupBallotExclusiveBitCount(ballot);
  if (wanted) listed[at] = uint(place.x) | uint(place.y) << 16u;
  subgroupSharedBarrier();
  return length + subgroupBallotBitCount(ballot);
}

// Lights the last pixels of the list, one per lane. Returns the new length.
uint lightListed(FrameConstants frame, View view, uint length) {
  uint left = length - min(length, gl_SubgroupSize), at = left + gl_SubgroupInvocationID;
  if (at < length) {
    uint pixel = listed[listBase + at];
    lightSurface(frame, view, readPixel(frame, view, ivec3(pixel & 0xffffu, pixel >> 16u, gl_WorkGroupID.z), 1u));
  }
  subgroupSharedBarrier();
  return left;
}

void lightSpan(FrameConstants frame, View view) {
  listBase = 2u * gl_SubgroupSize * gl_SubgroupID;
  uint length = 0u, block = 0u;
  do {
    ivec3 place = pixelOfSpan(block);
    length = appended(place, facesLight(frame, view, place), length);
    uint kept = ++block < blocksOfSpan() ? gl_SubgroupSize : 1u;
    while (length >= kept) length = lightListed(frame, view, length);
  } while (block < blocksOfSpan());
}

void main() {
  bindSurfaces(push.frame, push.shown);
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  View view = frameView(frame, gl_WorkGroupID.z);
  if (kSpan > 1u) {
    lightSpan(frame, view);
    return;
  }
  LitPixel p = readInside(frame, view, ownPixel());
  if (isReflecting(view, p)) lightSurface(frame, view, p);
}
