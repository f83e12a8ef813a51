// Shading from the lists of light_lists.comp.
#include "render/glsl/light_cells.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/lit_pixel.glsl"
#include "render/glsl/light_tree.glsl"
#include "render/lighting/lighting_push.h"

struct CellLights {
  CellsRef cells;    // of this workgroup's tile
  uint64_t entries;  // of the same: uint[]
};

// The frame's directional lights, then `count` lights of a list (uint[] by address), then, where `walks`, all local
// lights that the tree has near the surfaces; each part in the order of the lights. One loop for all: shading a light is
// most of a shader, and lavapipe compiles it wherever it stands, and takes more for a loop than for a round of it.
void shadeNear(inout Shading shading, FrameConstants frame, uint64_t list, uint count, bool walks) {
  TreeWalk walk = startWalk(frame, shading.low, shading.high, walks);
  uint next = 0u, end = frame.directionalLights + count;
  if (shading.lit) lightsTested += float(end);
  bool listed = true;
  while (true) {
    if (next >= end) {  // on to a leaf of the tree
      listed = false;
      if (!nextLeaf(walk, frame, next)) break;
      end = min(next + kLightTreeWidth, frame.lightCount);
      if (shading.lit) lightsTested += float(end - next);
    }
    uint light = min(next + laneRank, end - 1u);
    if (listed && light >= frame.directionalLights) light = UintRef(list).v[light - frame.directionalLights];
    DealtLight mine = dealtLight(frame, shading.view, light);
    shadeDealt(shading, frame, mine, next + laneRank < end && reaches(mine.light, shading.low, shading.high));
    next += lanesPresent;
  }
}

// What all lights send to the lanes that take part, whose surfaces lie in one cell of the tile. Where its list did not
// fit they come from the tree.
void shadeCell(inout Shading shading, FrameConstants frame, CellLights lights, uint cell) {
  uvec2 list = lights.cells.v[1u + cell];
  bool fits = list.y != kOverflow;
  shadeNear(shading, frame, lights.entries + uint64_t(list.x) * 4u, fits ? list.y : 0u, !fits);
}

// --- a pixel --------------------------------------------------------------------------------------------------------

// This invocation's place in the picture; workgroups are tiles.
ivec3 placeInTile() {
  return ivec3(gl_WorkGroupID.xy * kTileSize + pixelOfTile(gl_LocalInvocationIndex), gl_WorkGroupID.z);
}

// What all lights send from the pixel to the eye. The lanes of a subgroup whose surfaces lie in the same slice shade
// together, one slice after the other; where a tile is one cell whose list fits, all at once. (Where it does not fit,
// the boxes that the tree is walked with had better not span the depth of the scene. On lavapipe a shader's loops
// together end after 65535 rounds, without a word.)
vec3 shadeFromCells(LitPixel pixel, View view, FrameConstants frame, CellsPush push) {
  if (kLights == 0u) return vec3(0.0);
  uint64_t tile = tileOf(gl_WorkGroupID, push.tiles);
  CellLights lights = CellLights(CellsRef(push.cells + tile * (8u * (kCellsATile + 1u))),
                                 push.entries + tile * (4u * kEntriesATile));
  bool together = kCellsATile == 1u && lights.cells.v[1].y != kOverflow;
  uint slice = together ? 0u : sliceOf(depthKey(view.projection, pixel.depth), lights.cells.v[0]);
  vec3 radiance = vec3(0.0);
  bool waits = pixel.lit;
  while (subgroupAny(waits)) {
    uint next = subgroupMin(waits ? slice : kSlices);
    bool now = waits && slice == next;
    Shading shading = startShading(pixel.s, surfaceBrdf(pixel.s, pixel.toEye, kShading), uint(pixel.place.z), now);
    shadeCell(shading, frame, lights, kCellsATile == 1u ? 0u : next);
    if (now) radiance = shading.radiance;
    waits = waits && !now;
  }
  return radiance;
}
