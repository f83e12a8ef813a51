// Shading from the light lists of light_lists.comp, for compute shaders with one pixel per invocation. Include after
// the header that finds the surfaces.
#include "render/glsl/light_cells.glsl"
#include "render/glsl/lights.glsl"
#include "render/glsl/listed_lights.glsl"
#include "render/glsl/tree_lights.glsl"
#include "render/lighting/lighting_push.h"

struct CellLights {
  bool listed;       // false: every cell has all local lights, and `entries` is not set
  CellsRef cells;    // of one tile, or any memory
  uint64_t entries;  // of the same tile: uint[]
};

const uint kShortCell = 48u;  // maximum lights of a short list; the fastest of 16, 32, 48, 64 and 96 for most scenes

// Shades the lit lanes, whose surfaces lie in one cell of the tile, with all lights. If the cell's list overflowed, the
// lights come from the light tree.
void shadeCell(inout Shading shading, FrameConstants frame, CellLights lights, uint cell) {
  uvec2 list = lights.cells.v[lights.listed ? 1u + cell : 0u];
  list = lights.listed ? list : uvec2(0u, frame.lightCount - frame.directionalLights);
  bool fits = list.y != kOverflow;
  uint64_t indices = lights.listed ? lights.entries + uint64_t(list.x) * 4u : kAllLights;
  if (kCpuDevice == 0u && list.y <= kShortCell) {
    shadeListed(shading, frame, indices, list.y);
  } else {
    findBounds(shading);
    shadeNear(shading, frame, indices, fits ? list.y : 0u, !fits);
  }
}

// --- per pixel -------------------------------------------------------------------------------------------------------

// The position of a pixel's surface when the lists were built.
struct CellLookup {
  uvec3 block;  // of pixels, and the view: as gl_WorkGroupID
  Projection projection;
  float depth;  // device depth
};

// Returns the radiance that `s` reflects towards the eye from all lights. Every invocation of the workgroup's subgroup
// must call it; `lit` is false for invocations without a surface. The lanes whose surfaces lie in the same slice shade
// together, slice by slice; if the tile is one cell whose list fits, all lanes shade at once. (If the list overflowed,
// the boxes that query the light tree should not span the depth of the scene. On lavapipe, the loops of a shader end
// silently after 65535 iterations in total.)
vec3 shadeFromCells(FrameConstants frame, LightCells cells, CellLookup place, Surface s, LIT_BRDF brdf, bool lit) {
  uint64_t tile = tileOf(place.block / uvec3(kTileSize / kPixelGroupX, kTileSize / kPixelGroupY, 1u), cells.tiles);
  bool listed = cells.cells != uint64_t(0);
  // Without lists, other memory is loaded. In branches, compilers would replace its address by the lists' 0, from which
  // lavapipe of Mesa 26 loads even where a branch is not taken.
  uint64_t own = listed ? cells.cells + tile * (8u * (kCellsPerTile + 1u)) : frame.views;
  CellLights lights = CellLights(listed, CellsRef(own), cells.entries + tile * (4u * kEntriesPerTile));
  uvec2 slices = lights.cells.v[0], firstCell = lights.cells.v[1];
  bool sliced = listed && (kCellsPerTile > 1u || firstCell.y == kOverflow);
  uint slice = sliced ? sliceOf(depthKey(place.projection, place.depth), slices) : 0u;
  bool waits = lit;
  if (!subgroupAny(waits)) return vec3(0.0);
  countLanes();
  Shading shading = startShading(s, brdf, place.block.z, false);
  while (true) {
    uint next = subgroupMin(waits ? slice : kSlices);
    shading.lit = waits && slice == next;
    shadeCell(shading, frame, lights, kCellsPerTile == 1u ? 0u : next);
    waits = waits && !shading.lit;
    if (!subgroupAny(waits)) break;  // not at the beginning: lavapipe would execute the body once more
  }
  return shading.radiance;
}
