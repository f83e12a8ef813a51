#version 460
#extension GL_GOOGLE_include_directive : require
// Builds the depth pyramid (HZB) for occlusion culling: the farthest visible depth in squares of 4, 8, 16, 32 and 64
// pixels (Greene, Kass and Miller 1993, Hierarchical Z-Buffer Visibility, SIGGRAPH). Reads the visibility buffer,
// writes PyramidPush::pyramid. A workgroup reduces a tile of 64x64 pixels; a thread reads 4x4 of them.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/raster_push.h"
#include "render/visibility/compute/visible.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { PyramidPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PyramidRef { float v[]; };

shared float squares[16][16];

float farthestOfPixel(uvec3 pixel) {
  uint first = visibleIndex(pixel, uvec2(push.width, push.height));
  float farthest = 1.0;
  for (uint i = 0u; i < kSamples; ++i)
    farthest = min(farthest, visibleDepth(VisibleRef(push.visible).v[first + i]));
  return farthest;
}

// Pixels beyond the image count as nearest: they do not affect the minimum and are never tested.
float farthestOfSquare(uvec2 square, uint view) {
  float farthest = 1.0;
  for (uint y = 0u; y < kPyramidSquare; ++y)
    for (uint x = 0u; x < kPyramidSquare; ++x) {
      uvec2 pixel = square * kPyramidSquare + uvec2(x, y);
      if (all(lessThan(pixel, uvec2(push.width, push.height)))) farthest = min(farthest, farthestOfPixel(uvec3(pixel, view)));
    }
  return farthest;
}

void store(uint level, uvec2 square, uint view, float farthest) {
  uvec2 size = uvec2(pyramidSquares(push.width, level), pyramidSquares(push.height, level));
  uint first = view * pyramidOffset(push.width, push.height, kPyramidLevels) +
               pyramidOffset(push.width, push.height, level);
  if (all(lessThan(square, size))) PyramidRef(push.pyramid).v[first + square.y * size.x + square.x] = farthest;
}

void main() {
  uvec2 own = gl_LocalInvocationID.xy;
  uint view = gl_WorkGroupID.z;
  float farthest = farthestOfSquare(gl_WorkGroupID.xy * 16u + own, view);
  store(0u, gl_WorkGroupID.xy * 16u + own, view, farthest);
  squares[own.y][own.x] = farthest;
  for (uint level = 1u; level < kPyramidLevels; ++level) {
    barrier();
    uint side = 16u >> level;
    bool takesPart = all(lessThan(own, uvec2(side)));
    if (takesPart)
      farthest = min(min(squares[2u * own.y][2u * own.x], squares[2u * own.y][2u * own.x + 1u]),
                     min(squares[2u * own.y + 1u][2u * own.x], squares[2u * own.y + 1u][2u * own.x + 1u]));
    barrier();
    if (!takesPart) continue;
    squares[own.y][own.x] = farthest;
    store(level, gl_WorkGroupID.xy * side + own, view, farthest);
  }
}
