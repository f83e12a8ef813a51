#version 460
#extension GL_GOOGLE_include_directive : require
// Resolves depth from the visibility buffer; 0 is background.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/visible_triangle.glsl"
#include "render/visibility/compute/visible.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { ResolvePush push; };
layout(set = 0, binding = 0, r32f) writeonly uniform image2DArray depth;

// Returns the device depth of a triangle's plane at a position in the image.
float planeDepth(uint id, uint viewIndex, vec2 place) {
  FrameConstants frame = frameOf(push.frame, viewIndex);
  View view = frameView(frame, viewIndex);
  VisibleTriangle t = visibleTriangle(frame, push.instances, id);
  vec3 corners[3] = cornersOf(frame, view, t);
  vec3 weights = weightsAt(frame, view, corners[0], corners[1], corners[2], place).at;
  return deviceDepth(view.projection, dot(weights, vec3(corners[0].y, corners[1].y, corners[2].y)));
}

// Returns the depth of a multisampled pixel. If all samples show one triangle, it is their mean. Otherwise it is the
// depth of the first covered sample's plane at the pixel's center, clamped to the samples' range, because a mean would
// lie between two surfaces.
float depthAtCenter(ivec3 pixel, uint first) {
  VisibleRef visible = VisibleRef(push.visible);
  float least = 1.0, most = 0.0, sum = 0.0;
  uint id = 0u;
  bool alike = true;
  for (uint i = 0u; i < kSamples; ++i) {
    uint64_t shown = visible.v[first + i];
    alike = alike && visibleId(shown) == visibleId(visible.v[first]);
    sum += visibleDepth(shown);
    if (shown == uint64_t(0)) continue;
    if (id == 0u) id = visibleId(shown);
    least = min(least, visibleDepth(shown));
    most = max(most, visibleDepth(shown));
  }
  if (alike) return sum / float(kSamples);
  float depth = planeDepth(id, uint(pixel.z), vec2(pixel.xy) + 0.5);
  return clamp(depth >= 0.0 ? depth : least, least, most);
}

void main() {
  ivec3 size = imageSize(depth), pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel, size))) return;
  uint first = visibleIndex(uvec3(pixel), uvec2(size.xy));
  float found = kSamples == 1u ? visibleDepth(VisibleRef(push.visible).v[first]) : depthAtCenter(pixel, first);
  imageStore(depth, pixel, vec4(found));
}
