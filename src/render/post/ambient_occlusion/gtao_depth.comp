#version 460
#extension GL_GOOGLE_include_directive : require
// GTAO without a G-buffer: normals are derived from the depth buffer. Input: gbufferDepth. Output: occlusion, the
// occluded fraction.
#include "render/glsl/common.glsl"
layout(set = 0, binding = 0) uniform sampler2DArray gbufferDepth;
#include "render/post/ambient_occlusion/gtao.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 1, r32f) uniform writeonly image2DArray occlusion;

void main() {
  View view = frameView(FrameRef(push.frame).v, gl_GlobalInvocationID.z);
  ivec3 place = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(vec2(place.xy), view.size))) return;
  float depth = texelFetch(gbufferDepth, place, 0).r;
  float occluded = 0.0;
  if (depth != 0.0) {
    Center center = centerAt(view, place, depth);
    occluded = occlusionAt(view, center, normalFromDepth(view, center));
  }
  imageStore(occlusion, place, vec4(occluded));
}
