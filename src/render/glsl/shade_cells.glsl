// Shading from the lists of light_lists.comp, of compute shaders with a pixel an invocation. After what finds surfaces.
#include "render/glsl/light_cells.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/listed_lights.glsl"
#include "render/glsl/tree_lights.glsl"
#include "render/lighting/lighting_push.h"

struct CellLights {
  CellsRef cells;    // of the tile
  uint64_t entries;  // of the same: uint[]
};

const uint kShortCell = 48u;  // lights; of 16, 32, 48, 64 and 96 the best for most numbers of lights in a scene

// What all lights send to the lanes that take part, whose surfaces lie in one cell of the tile. Where its list did not
// fit they come from the tree.
void shadeCell(inout Shading shading, FrameConstants frame, CellLights lights, uint cell) {
  uvec2 list = lights.cells.v[1u + cell];
  bool fits = list.y != kOverflow;
  uint64_t indices = lights.entries + uint64_t(list.x) * 4u;
  if (kCpuDevice == 0u && list.y <= kShortCell) {
    shadeListed(shading, frame, indices, list.y);
  } else {
    findBounds(shading);
    shadeNear(shading, frame, indices, fits ? list.y : 0u, !fits);
  }
}

// --- a pixel ---------------------------------------------------------------------------------------------------------

// Where a pixel's surface was when the lists were made.
struct CellPlace {
  uint view;
  Projection projection;
  float depth;  // of the device
};

// Radiance that all lights send from `s` to the eye. Every invocation of the workgroup's subgroup must call it; `lit` is
// false for those without a surface. The lanes of a subgroup whose surfaces lie in the same slice shade together, one
// slice after the other; where a tile is one cell whose list fits, all at once. (Where it does not fit, the boxes that
// the tree is walked with had better not span the depth of the scene. On lavapipe a shader's loops together end after
// 65535 rounds, without a word.)
vec3 shadeFromCells(FrameConstants frame, LightCells cells, CellPlace place, Surface s, LIT_BRDF brdf, bool lit) {
  uint64_t tile = tileOf(gl_WorkGroupID / uvec3(kTileSize / kPixelGroupX, kTileSize / kPixelGroupY, 1u), cells.tiles);
  CellLights lights = CellLights(CellsRef(cells.cells + tile * (8u * (kCellsATile + 1u))),
                                 cells.entries + tile * (4u * kEntriesATile));
  bool together = kCellsATile == 1u && lights.cells.v[1].y != kOverflow;
  uint slice = together ? 0u : sliceOf(depthKey(place.projection, place.depth), lights.cells.v[0]);
  bool waits = lit;
  if (!subgroupAny(waits)) return vec3(0.0);
  countLanes();
  Shading shading = startShading(s, brdf, place.view, false);
  while (true) {
    uint next = subgroupMin(waits ? slice : kSlices);
    shading.lit = waits && slice == next;
    shadeCell(shading, frame, lights, kCellsATile == 1u ? 0u : next);
    waits = waits && !shading.lit;
    if (!subgroupAny(waits)) break;  // not at the top: lavapipe would go round once more
  }
  return shading.radiance;
}
