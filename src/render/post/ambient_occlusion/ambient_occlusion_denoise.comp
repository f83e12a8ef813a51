#version 460
#extension GL_GOOGLE_include_directive : require
// GTAO, denoising: averages occlusion over the 4x4 pattern of gtao.glsl along one axis. The filter has five pixels with
// half weight for the outer ones, so it weights the four phases equally and is centered on the pixel. The weight of a
// pixel decreases with its distance from the center pixel's plane or from its depth, whichever is smaller. Inputs:
// gbufferDepth and hidden. Output: result.
#include "render/glsl/common.glsl"
#include "render/glsl/pixel_ray.glsl"
#include "render/post/ambient_occlusion/ambient_occlusion_push.h"
#include "shared/ambient_occlusion.h"

layout(local_size_x = 16, local_size_y = 16) in;
// 1: second axis, which outputs visibility instead of occlusion.
layout(constant_id = kLastAxisConstant) const uint kLast = 0;
layout(set = 0, binding = 0) uniform sampler2DArray gbufferDepth;
layout(set = 0, binding = 1) uniform sampler2DArray occluded;
layout(set = 0, binding = 2, r32f) uniform writeonly image2DArray result;
layout(push_constant, scalar) uniform Push { DenoisePush push; };

const ivec3 kAxis = ivec3(kLast == 0u ? 1 : 0, kLast == 0u ? 0 : 1, 0);

// Removes the neighbors whose rays are not next to the pixel's, such as those on another face of a cube map.
void dropFarNeighbors(View view, ivec3 place, inout float depths[5]) {
  FrameConstants frame = frameOf(push.frame, place.z);
  vec3 here = lensRay(frame, view, place.xy).direction;
  float shortest = length(lensStep(frame, view, place.xy, kAxis.xy));
  for (int i = 0; i < 5; ++i) {
    if (i == 2 || depths[i] == 0.0) continue;
    vec3 there = lensRay(frame, view, place.xy + kAxis.xy * (i - 2)).direction;
    if (length(there - here) > 2.0 * float(abs(i - 2)) * shortest) depths[i] = 0.0;
  }
}

void main() {
  ivec3 place = ivec3(gl_GlobalInvocationID);
  View view = frameView(FrameRef(push.frame).v, gl_GlobalInvocationID.z);
  ivec3 last = ivec3(ivec2(view.size) - 1, place.z);
  if (any(greaterThan(place.xy, last.xy))) return;
  float depths[5], values[5];
  for (int i = 0; i < 5; ++i) {
    ivec3 at = place + kAxis * (i - 2);
    bool inside = at == clamp(at, ivec3(0, 0, place.z), last);
    depths[i] = inside ? texelFetch(gbufferDepth, at, 0).r : 0.0;
    values[i] = inside ? texelFetch(occluded, at, 0).r : 0.0;
  }
  if (kLens != 0u) dropFarNeighbors(view, place, depths);
  float before = depths[2] - depths[1], after = depths[3] - depths[2];
  if (depths[1] == 0.0) before = 3.0e38;
  if (depths[3] == 0.0) after = 3.0e38;
  float slope = abs(before) < abs(after) ? before : after;
  if (abs(slope) > 1.0e38) slope = 0.0;
  float meters = kWorlds != 0u ? push.share * frameOf(push.frame, gl_WorkGroupID.z).aoRadius : push.tolerance;
  float tolerance = max(deviceDepthStep(view.projection, depths[2], meters), 1.0e-37);
  float sum = values[2], weights = 1.0;
  for (int i = 0; i < 5; ++i) {
    // The slope of a strip that is one pixel wide comes from its surroundings, so pixels of equal depth are included as
    // well.
    float step = depths[i] - depths[2];
    float off = min(abs(step - slope * float(i - 2)), abs(step));
    float weight = i == 2 || depths[i] == 0.0 ? 0.0 : max(1.0 - off / tolerance, 0.0);
    if (i == 0 || i == 4) weight *= 0.5;
    sum += weight * values[i];
    weights += weight;
  }
  float mean = sum / weights;
  if (kLast != 0u) mean = depths[2] == 0.0 ? 1.0 : pow(clamp(1.0 - mean, 0.0, 1.0), push.strength);
  imageStore(result, place, vec4(mean));
}
