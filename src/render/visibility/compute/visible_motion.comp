#version 460
#extension GL_GOOGLE_include_directive : require
// Resolves motion vectors from the visibility buffer, including those of the background.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/visible_triangle.glsl"
#include "render/visibility/compute/visible_motion.glsl"
#include "render/visibility/compute/visible.glsl"
#include "render/visibility/background_motion.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { ResolvePush push; };
layout(set = 0, binding = 0) writeonly uniform image2DArray motion;

void main() {
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  View view = frameView(frame, uint(pixel.z));
  ivec2 size = ivec2(view.size);
  if (any(greaterThanEqual(pixel.xy, size))) return;
  uint id = visibleId(VisibleRef(push.visible).v[visibleIndex(uvec3(pixel), uvec2(size))]);
  vec2 centre = vec2(pixel.xy) + 0.5;
  vec4 found = id == 0u ? backgroundMotion(frame, view, uint(pixel.z), centre)
                        : seenMotion(frame, view, uint(pixel.z), visibleTriangle(frame, push.instances, id), centre);
  imageStore(motion, pixel, found);
}
