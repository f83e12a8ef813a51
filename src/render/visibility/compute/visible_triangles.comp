#version 460
#extension GL_GOOGLE_include_directive : require
// Reads the visible triangles from the visibility buffer: the number of the instance, from 1, and the index of the
// triangle in its mesh.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/visible_triangle.glsl"
#include "render/visibility/compute/visible.glsl"
#include "render/glsl/covered_tiles.glsl"
#include "render/glsl/pixel_group.glsl"

layout(push_constant, scalar) uniform Push { ResolvePush push; };
layout(set = 0, binding = 0) writeonly uniform uimage2DArray triangles;

void main() {
  ivec3 size = imageSize(triangles), pixel = pixelOf(ownBlock(push.covered));
  if (any(greaterThanEqual(pixel, size))) return;
  uint id = visibleId(VisibleRef(push.visible).v[visibleIndex(uvec3(pixel), uvec2(size.xy))]);
  uvec2 found = uvec2(0u);
  if (id != 0u) {
    VisibleTriangle t = visibleTriangle(frameOf(push.frame, uint(pixel.z)), push.instances, id);
    found = uvec2(t.draw.instance + 1u, t.number);
  }
  imageStore(triangles, pixel, uvec4(found, 0u, 0u));
}
