#version 460
#extension GL_GOOGLE_include_directive : require
// tiled: the lights of a tile's list at each of its pixels.
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/glsl/shade_cells.glsl"

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform Push { CellsPush push; };

void main() {
  countLanes();
  FrameConstants frame = FrameRef(push.frame).v;
  ivec3 place = ivec3(gl_WorkGroupID.xy * kTileSize + pixelOfTile(gl_LocalInvocationIndex), gl_WorkGroupID.z);
  LitPixel pixel = readPixel(frame, frameView(frame, place.z), place);
  Shading shading = startShading(pixel.s, pixel.toEye, pixel.lit);
  if (subgroupAny(pixel.lit)) shadeCell(shading, frame, cellsOfTile(push), 0u);
  writePixel(frame, pixel, shading.radiance, lightCount());
}
