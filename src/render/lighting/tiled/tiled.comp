#version 460
#extension GL_GOOGLE_include_directive : require
// tiled: the lights of a tile's list at each of its pixels.
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/shade_cells.glsl"

layout(local_size_x = 256) in;
layout(push_constant, scalar) uniform Push { CellsPush push; };

void main() {
  countLanes();
  FrameConstants frame = FrameRef(push.frame).v;
  ivec3 place = placeInTile();
  View view = frameView(frame, place.z);
  LitPixel pixel = readPixel(frame, view, place);
  vec3 byLights = shadeFromCells(pixel, view, frame, push);
  writePixel(frame, pixel, byLights, lightCount());
}
