#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible, multisampled, layered
// tiled and clustered: shades each pixel with the light list of its tile, or of its slice of it.
#include "render/glsl/common.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/shade_cells.glsl"

layout(push_constant, scalar) uniform Push { CellsPush push; };

vec3 lightsAt(FrameConstants frame, View view, LitPixel p) { return shadeFromCells(p, view, frame, push); }

void main() {
  countLanes();
  showSurfaces(push.frame, push.shown);
  ivec3 place = ownPixel();
  bool lit = lightPixel(FrameRef(push.frame).v, place);
  writeCounts(place, lit, lightCount());
}
