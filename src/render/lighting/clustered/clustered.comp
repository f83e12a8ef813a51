#version 460
#extension GL_GOOGLE_include_directive : require
// clustered: the lights of a list for each slice of a tile at the pixels that lie in it. The lanes of a subgroup whose
// surfaces lie in the same slice shade together, one slice after the other.
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
  View view = frameView(frame, place.z);
  LitPixel pixel = readPixel(frame, view, place);
  CellLights lights = cellsOfTile(push);
  uint slice = sliceOf(depthKey(view.projection, pixel.depth), lights.cells.v[0]);
  vec3 radiance = vec3(0.0);
  bool waits = pixel.lit;
  while (subgroupAny(waits)) {
    uint next = subgroupMin(waits ? slice : kSlices);
    bool now = waits && slice == next;
    Shading shading = startShading(pixel.s, pixel.toEye, now);
    shadeCell(shading, frame, lights, next);
    if (now) radiance = shading.radiance;
    waits = waits && !now;
  }
  writePixel(frame, pixel, radiance, lightCount());
}
