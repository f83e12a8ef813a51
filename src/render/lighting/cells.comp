#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, visible, multisampled, sample-layers
// Tiled and clustered deferred shading: shades each pixel with the light list of its cell, which light_lists.comp
// wrote. A cell is a tile (tiled) or a depth slice of a tile (clustered). Inputs: the G-buffer and the lists. Output:
// the lit picture in lightTarget, and the numbers of lights tested and used in lightCounts.
#include "render/glsl/common.glsl"
#include "render/glsl/covered_tiles.glsl"
#include "render/glsl/gbuffer_read.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/glsl/shade_cells.glsl"

layout(push_constant, scalar) uniform Push { CellsPush push; };

uvec3 block;  // of this workgroup's pixels, and their view

vec3 lightsAt(FrameConstants frame, View view, LitPixel p) {
  if (kLights == 0u || !subgroupAny(p.lit)) return vec3(0.0);
  CellLookup place = CellLookup(block, view.projection, p.depth);
  return shadeFromCells(frame, push.lists, place, p.s, surfaceBrdf(p.s, p.toEye, kShading), p.lit);
}

void main() {
  bindSurfaces(push.frame, push.shown);
  block = ownBlock(push.covered);
  ivec3 place = pixelOf(block);
  bool lit = lightPixel(uniformFrame(push.frame, block.z), place);
  writeCounts(place, lit, lightCount());
}
