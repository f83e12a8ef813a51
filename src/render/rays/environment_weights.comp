#version 460
#extension GL_GOOGLE_include_directive : require
// The mean brightness of an environment's image in each cell of the grid by which rays sample it (shared/rays.h). One
// invocation per cell; output: push.weights. The mean is that of the largest channel, so that no color is missed.
#include "render/glsl/common.glsl"
#include "render/rays/environment_push.h"
#include "shared/color.h"
#include "shared/rays.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2D environmentPicture;

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer WeightsRef { float v[]; };

layout(push_constant, scalar) uniform Push { EnvironmentWeightsPush push; };

void main() {
  uvec2 cell = gl_GlobalInvocationID.xy, cells = uvec2(kEnvironmentColumns, kEnvironmentRows);
  if (any(greaterThanEqual(cell, cells))) return;
  uvec2 size = uvec2(textureSize(environmentPicture, 0));
  // With a margin of one texel, because the image is filtered.
  ivec2 first = ivec2(cell * size / cells) - 1, end = ivec2(((cell + 1u) * size + cells - 1u) / cells) + 1;
  float sum = 0.0;
  for (int y = first.y; y < end.y; ++y)
    for (int x = first.x; x < end.x; ++x) {
      ivec2 texel = ivec2((x + int(size.x)) % int(size.x), clamp(y, 0, int(size.y) - 1));
      sum += maxChannel(texelFetch(environmentPicture, texel, 0).rgb);
    }
  float texels = float((end.x - first.x) * (end.y - first.y));
  WeightsRef(push.weights).v[cell.y * kEnvironmentColumns + cell.x] = sum / texels;
}
