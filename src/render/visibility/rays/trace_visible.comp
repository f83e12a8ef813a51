#version 460
#extension GL_GOOGLE_include_directive : require
// Fills the visibility buffer by rays: each sample's own ray finds the nearest opaque or masked triangle in the BVHs of
// glsl/rays.glsl. The depth is that of the triangle's plane, as rasterization computes it.
//
//   FrameConstants::rayScene, views  ->  trace_visible  ->  visible (visible.glsl)
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/glsl/pixel_span.glsl"
#include "render/visibility/compute/visible.glsl"
#include "render/visibility/rays/trace_push.h"
#include "render/visibility/triangle_depth.glsl"

layout(push_constant, scalar) uniform Push { TraceVisiblePush push; };
layout(constant_id = kVastConstant) const uint kVast = 0u;            // FrameConfig::vast
layout(constant_id = kAlphaTestConstant) const uint kAlphaTest = 0u;  // 0: no triangles are alpha tested

#define RAY_ALPHA_TESTS (kAlphaTest != 0u)
#define RAY_ORDER(instance) UintRef(push.firstTriangles).v[instance]
#include "render/glsl/eye_ray.glsl"

float depthOfTriangle(View view, Instance instance, uint64_t positions, uvec3 corners, vec2 place) {
  mat4x3 placed = relativeToEye(instance, view);
  vec3 seen[3];
  float least = 1.0, most = 0.0;
  for (int i = 0; i < 3; ++i) {
    seen[i] = seenPosition(view, placed, positionAt(positions, corners[i]));
    vec4 clip = clipPosition(view, seen[i]);
    // A corner behind the eye has no depth. The plane's depth is then that of a visible point anyway.
    float depth = clip.w > 0.0 ? deviceDepthOf(clip) : 1.0;
    least = min(least, depth);
    most = max(most, depth);
  }
  vec3 plane = depthPlane(view, seen[0], seen[1], seen[2]);
  vec2 range = depthRange(view, plane, least, most);
  return withinRange(range.x, range.y, depthOn(plane, rayAt(view, place)));
}

ViewPlane vastPlane(View view, Instance instance, uint64_t positions, uvec3 corners) {
  Exact3 seen[3];
  for (int i = 0; i < 3; ++i) seen[i] = seenExactly(view, instance, positionAt(positions, corners[i]));
  return planeOf(seen[0], seen[1], seen[2]);
}

float depthOfVast(FrameConstants frame, View view, ViewPlane plane, vec2 place) {
  if (kLens != 0u) {
    float distance = plane.distance / dot(plane.normal, pixelRay(frame, view, place));
    return deviceDepth(view.projection, distance);
  }
  return clamp(depthOn(depthPlane(view.projection, plane.normal, plane.distance), rayAt(view, place)), 0.0, 1.0);
}

// Returns the value of the visibility buffer for the surface that a ray hits.
uint64_t visibleOf(FrameConstants frame, View view, RayHit hit, vec2 place) {
  Instance instance = frameInstance(frame, hit.instance);
  uint64_t positions = meshPositions(frame, instance.mesh);
  float depth;
  if (kLens != 0u)
    depth = deviceDepth(view.projection, hit.distance);
  else
    depth = depthOfTriangle(view, instance, positions, hit.corners, place);
  if (kVast != 0u && (instance.flags & kInstanceVast) != 0u)
    depth = depthOfVast(frame, view, vastPlane(view, instance, positions, hit.corners), place);
  return visibleValue(depth, UintRef(push.firstTriangles).v[hit.instance] + hit.triangle + 1u);
}

void traceSamples(FrameConstants frame, View view, ivec3 pixel) {
  if (any(greaterThanEqual(vec2(pixel.xy), view.size))) return;
  uint first = visibleIndex(uvec3(pixel), uvec2(view.size)), what = push.surfaces | view.group << kRayGroupShift;
  uint i = 0u;
  do {  // tested at the end, here and below, because lavapipe would execute the body once more
    vec2 place = vec2(pixel.xy) + samplePlace(kSamples, i);
    RayHit hit = traceRay(frame, rayThrough(frame, view, place), what);
    uint64_t visible = uint64_t(0);
    if (isHit(hit)) visible = visibleOf(frame, view, hit, place);
    VisibleRef(push.visible).v[first + i] = visible;
  } while (++i < kSamples);
}

void main() {
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  View view = frameView(frame, gl_WorkGroupID.z);
  uint block = 0u;
  do {
    traceSamples(frame, view, pixelOfSpan(block));
  } while (++block < blocksOfSpan());
}
