#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible
// GTAO with a G-buffer: normals come from the layout. Inputs: the G-buffer. Output: occlusion, the occluded fraction.
#include "render/glsl/common.glsl"
#define ONE_SAMPLE
#define GBUFFER_SAMPLED_ONLY
#include "render/glsl/gbuffer_read.glsl"
#include "render/post/ambient_occlusion/gtao.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = GBUFFER_BINDINGS, r32f) uniform writeonly image2DArray occlusion;

void main() {
  bindSurfaces(push.frame, push.shown);
  View view = frameView(FrameRef(push.frame).v, gl_GlobalInvocationID.z);
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(vec2(place.xy), view.size))) return;
  float depth = texelFetch(gbufferDepth, place, 0).r;
  float occluded = 0.0;
  if (depth != 0.0) {
    vec3 normal = rotateToView(view, readSurface(view, place, depth, 1.0).normal);
    occluded = occlusionAt(view, centerAt(view, place, depth), normal);
  }
  imageStore(occlusion, place, vec4(occluded));
}
