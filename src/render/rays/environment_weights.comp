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
  // The image is filtered, so its texels are sampled also between their centers.
  uvec2 points = max((uvec2(textureSize(environmentPicture, 0)) + cells - 1u) / cells, uvec2(2u));
  float sum = 0.0;
  for (uint y = 0u; y < points.y; ++y)
    for (uint x = 0u; x < points.x; ++x) {
      vec2 uv = (vec2(cell) + (vec2(x, y) + 0.5) / vec2(points)) / vec2(cells);
      sum += maxChannel(textureLod(environmentPicture, uv, 0.0).rgb);
    }
  float mean = sum / float(points.x * points.y);
  WeightsRef(push.weights).v[cell.y * kEnvironmentColumns + cell.x] = mean;
}
