#version 460
#extension GL_GOOGLE_include_directive : require
// Resolves motion vectors from the visibility buffer, including those of the background. With kMotionOfSurfaces, zw are
// those of MotionUse::Surfaces.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/visible_triangle.glsl"
#include "render/visibility/compute/visible_motion.glsl"
#include "render/visibility/compute/visible.glsl"
#include "render/visibility/background_motion.glsl"
#include "render/visibility/compute/visible_motion_push.h"

layout(constant_id = kMotionOfSurfacesConstant) const uint kMotionOfSurfaces = 0;

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { VisibleMotionPush push; };
layout(set = 0, binding = 0) writeonly uniform image2DArray motion;

#include "render/visibility/compute/lens_motion.glsl"

void main() {
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  View view = frameView(frame, uint(pixel.z));
  ivec2 size = ivec2(view.size);
  if (any(greaterThanEqual(pixel.xy, size))) return;
  uint id = visibleId(VisibleRef(push.visible).v[visibleIndex(uvec3(pixel), uvec2(size))]);
  vec2 center = vec2(pixel.xy) + 0.5;
  uint index = uint(pixel.z);
  vec4 found;
  if (kLens != 0u)
    found = id == 0u ? backgroundLensMotion(frame, view, index, pixel.xy)
                     : seenLensMotion(frame, view, index, visibleTriangle(frame, push.instances, id), center);
  else
    found = id == 0u ? backgroundMotion(frame, view, index, center)
                     : seenMotion(frame, view, index, visibleTriangle(frame, push.instances, id), center);
  if (kMotionOfSurfaces != 0u) {
    found.zw = vec2(1.0, 0.0);
    if (id != 0u) {
      VisibleTriangle t = visibleTriangle(frame, push.instances, id);
      found.zw = vec2(seenApproach(frame, view, index, t, center), float(t.draw.instance + 1u));
    }
  }
  imageStore(motion, pixel, found);
}
