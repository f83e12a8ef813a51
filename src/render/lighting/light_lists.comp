#version 460
#extension GL_GOOGLE_include_directive : require
// variants: multisampled, sample-layers
// Light culling: lists the lights that may reach the samples of each cell, for tiled and clustered deferred shading. A
// cell is a tile of 16x16 pixels or a depth slice of a tile (kCellsPerTile). With several samples per pixel, the
// centroids of a pixel's surfaces stand for its samples, because surfaces are lit there.
//
// One subgroup builds the lists of a tile. It computes the bounding box of each cell's samples in world space (explicit
// bounds: Olsson, Billeter and Assarsson 2012, Clustered Deferred and Forward Shading, HPG) and traverses the light
// tree with that box. A tile that is a single cell also has a mask of the slices that contain samples, and rejects
// lights that reach none of them (2.5D culling: Harada 2012, A 2.5D Culling for Forward+, SIGGRAPH Asia technical
// briefs).
//
// Inputs: gbufferDepth, the light tree and, if MULTISAMPLED, pixelSurfaces. Outputs: push.lists.cells, with the slices
// and the cells of each tile, and push.lists.entries, with the indices of lights (light_cells.glsl). Each tile has its
// own part of the entries, so no list depends on the order in which lists are built. A list that overflows is marked,
// and the lighting shader traverses the tree instead.
#include "render/glsl/common.glsl"
#include "render/glsl/light_cells.glsl"
#include "render/glsl/light_tree.glsl"
#include "render/glsl/multisample.glsl"
#include "render/glsl/pixel_ray.glsl"
#include "render/lighting/lighting_push.h"
#include "shared/light.h"

const uint kTilesPerGroup = 8u;
layout(local_size_x = 256) in;
layout(set = 0, binding = 0) uniform TARGET_SAMPLER gbufferDepth;
#ifdef MULTISAMPLED
layout(set = 0, binding = 1) uniform usampler2DArray pixelSurfaces;
#endif

layout(push_constant, scalar) uniform Push { CellsPush push; };

struct Tile {
  View view;
  uint layer;
  uvec2 corner;  // first pixel
  uint index;    // among the tiles of all views
  uvec2 slices;
  uint occupied;  // mask of the slices that contain samples
  uint used;      // entries in use
};

// The number of surfaces in a pixel, and the mask of samples that show each. Without MULTISAMPLED a pixel has one
// sample.
#ifdef MULTISAMPLED
uint surfacesAt(Tile tile, uvec2 pixel) {
  if (any(greaterThanEqual(vec2(pixel), tile.view.size))) return 0u;
  return countSurfaces(pixelSurfaces, ivec3(pixel, tile.layer)).x;
}
uint samplesOf(Tile tile, uvec2 pixel, uint surface) {
  return surfaceSamples(pixelSurfaces, ivec3(pixel, tile.layer), surface);
}

float depthAt(Tile tile, uvec2 pixel, uint samples) {
  return depthOfSamples(gbufferDepth, ivec3(pixel, tile.layer), samples);
}
#else
uint surfacesAt(Tile tile, uvec2 pixel) { return 1u; }
uint samplesOf(Tile tile, uvec2 pixel, uint surface) { return 1u; }

float depthAt(Tile tile, uvec2 pixel, uint samples) {
  if (any(greaterThanEqual(vec2(pixel), tile.view.size))) return 0.0;
  return texelFetch(gbufferDepth, ivec3(pixel, tile.layer), 0).r;
}
#endif

uvec2 tilePixel(Tile tile, uint first) { return tile.corner + mortonPixel(min(first + laneRank, 255u)); }

// --- slices ---------------------------------------------------------------------------------------------------------

// The minimum number of key bits per slice. In a perspective view a slice is at least 1/8 to 1/16 of its distance deep,
// in an orthographic view at least as deep as a tile is wide. Thinner slices would split tiles without rejecting
// lights. Thicker slices reduce the time by 3 % with few lights (on an H200), but with a million lights the lists
// overflow and lighting needs three times as long.
uint leastSliceBits(View view) {
  Projection p = view.projection;
  if (p.kind == kPerspective) return 20u;
  float width = 2.0 * float(kTileSize) / (p.H * view.size.x);
  return uint(clamp(log2(abs(p.A) * width * 16777216.0), 0.0, 24.0));
}

// The depth keys of a tile's nearest and farthest samples.
struct Keys {
  uint nearest, farthest;
};
void addKey(inout Keys keys, Tile tile, float depth) {
  uint key = depthKey(tile.view.projection, depth);
  if (depth != 0.0) keys.nearest = max(keys.nearest, key);
  if (depth != 0.0) keys.farthest = min(keys.farthest, key);
}
uint sliceBit(Tile tile, float depth) {
  return depth != 0.0 ? 1u << sliceOf(depthKey(tile.view.projection, depth), tile.slices) : 0u;
}

#ifndef MULTISAMPLED
// On a GPU, a full subgroup issues the loads of all depths of its tile together and caches the values in registers.
// This reduces the time for lists by a fifth (on an H200) compared with waiting for each load in turn.
float depths[256u / kSubgroupSize];
bool keepsDepths() { return kCpuDevice == 0u && lanesPresent == kSubgroupSize; }
#endif

void findKeys(Tile tile, inout Keys keys) {
#ifndef MULTISAMPLED
  if (keepsDepths()) {
    for (uint i = 0u; i < 256u / kSubgroupSize; ++i) depths[i] = depthAt(tile, tilePixel(tile, i * kSubgroupSize), 1u);
    for (uint i = 0u; i < 256u / kSubgroupSize; ++i) addKey(keys, tile, depths[i]);
    return;
  }
#endif
  for (uint first = 0u; first < 256u; first += lanesPresent) {
    uvec2 pixel = tilePixel(tile, first);
    uint surfaces = surfacesAt(tile, pixel);
    for (uint i = 0u; i < surfaces; ++i) addKey(keys, tile, depthAt(tile, pixel, samplesOf(tile, pixel, i)));
  }
}

uint findOccupied(Tile tile) {
  uint occupied = 0u;
#ifndef MULTISAMPLED
  if (keepsDepths()) {
    for (uint i = 0u; i < 256u / kSubgroupSize; ++i) occupied |= sliceBit(tile, depths[i]);
    return occupied;
  }
#endif
  for (uint first = 0u; first < 256u; first += lanesPresent) {
    uvec2 pixel = tilePixel(tile, first);
    uint surfaces = surfacesAt(tile, pixel);
    for (uint i = 0u; i < surfaces; ++i) occupied |= sliceBit(tile, depthAt(tile, pixel, samplesOf(tile, pixel, i)));
  }
  return occupied;
}

// Returns false if the tile has no samples.
bool findSlices(inout Tile tile) {
  Keys keys = Keys(0u, 0xffffffffu);
  findKeys(tile, keys);
  uint nearest = subgroupMax(keys.nearest), farthest = subgroupMin(keys.farthest);
  if (farthest > nearest) return false;
  // The minimum number of bits that results in at most kSlices slices.
  uint bits = uint(max(findMSB(nearest - farthest) - 4, 0));
  tile.slices = uvec2(nearest, max(bits, leastSliceBits(tile.view)));
  tile.occupied = subgroupOr(findOccupied(tile));
  return true;
}

// --- light culling --------------------------------------------------------------------------------------------------

struct Cell {
  uint slices;  // mask of the slices that form the cell
  vec3 low, high;
};

// The bounding box of the cell's samples in world space. The slack covers layouts that store interpolated positions,
// which differ from positions computed from depth by a few millionths of the distance.
Cell cellOf(Tile tile, FrameConstants frame, uint slices) {
  vec3 low = vec3(3.0e38), high = vec3(-3.0e38);
  for (uint first = 0u; first < 256u; first += lanesPresent) {
    uvec2 pixel = tilePixel(tile, first);
    uint surfaces = surfacesAt(tile, pixel);
    for (uint i = 0u; i < surfaces; ++i) {
      uint samples = samplesOf(tile, pixel, i);
      float depth = depthAt(tile, pixel, samples);
      uint slice = sliceOf(depthKey(tile.view.projection, depth), tile.slices);
      bool inCell = depth != 0.0 && (slices >> slice & 1u) != 0u;
      Projection p = tile.view.projection;
      vec2 place = vec2(pixel) + sampleCentroid(samples);
      vec3 v = kLens != 0u ? pixelRay(frame, tile.view, place) * viewDepth(p, depth)
                           : viewPositionAtDepth(p, pixelToNdc(place, tile.view.size), viewDepth(p, depth));
      vec3 position = tile.view.viewToWorld * vec4(v, 1.0);
      float slack = 1e-4 * (abs(v.x) + abs(v.y) + abs(v.z));
      low = inCell ? min(low, position - slack) : low;
      high = inCell ? max(high, position + slack) : high;
    }
  }
  return Cell(slices, subgroupMin(low), subgroupMax(high));
}

// Tests the sphere around a box against a spot light's cone (Wronski 2017, Cull that cone!).
bool coneReaches(Light l, vec3 low, vec3 high) {
  vec3 to = 0.5 * (low + high) - l.position;
  float radius = 0.5005 * length(high - low) + 1e-5 * length(to);
  float along = dot(to, l.direction);
  float cosine = clamp(-l.spotOffset / l.spotScale, -1.0, 1.0);
  float sine = sqrt(1.0 - cosine * cosine);
  return cosine * sqrt(max(dot(to, to) - along * along, 0.0)) - along * sine <= radius;
}

// The depth key of a view depth, to compare with the keys of samples.
uint keyAt(Projection p, float depth) {
  if (p.kind == kOrthographic) return uint(clamp((p.A * depth + p.B) * 16777216.0, 0.0, 33554432.0));
  return depth <= 0.0 ? 0x7f7fffffu : floatBitsToUint(abs(p.B) / depth);
}

// Returns true if a sphere reaches into the space between the two planes a x + b y + c = 0 that bound the tile along
// one axis, in view space.
bool betweenSides(float scale, float offset, vec2 bounds, float across, float depth, float radius, bool perspective) {
  vec2 slope = perspective ? vec2(offset) - bounds : vec2(0.0);
  vec2 constant = perspective ? vec2(0.0) : vec2(offset) - bounds;
  vec2 inward = (scale * across + slope * depth + constant) * vec2(1.0, -1.0);
  return all(greaterThanEqual(inward, -radius * sqrt(scale * scale + slope * slope)));
}

bool reachesTile(Tile tile, vec3 center, float reach) {
  if (kLens != 0u) return true;  // with a lens, the sides of a tile are not planes
  Projection p = tile.view.projection;
  vec2 first = pixelToNdc(vec2(tile.corner), tile.view.size);
  vec2 last = pixelToNdc(vec2(tile.corner + kTileSize), tile.view.size);
  bool perspective = p.kind == kPerspective;
  return betweenSides(p.H, p.X, vec2(first.x, last.x), center.x, center.y, reach, perspective) &&
         betweenSides(p.V, p.Z, vec2(last.y, first.y), center.z, center.y, reach, perspective);
}

// The mask of the tile's slices that a light reaches.
uint slicesReached(Tile tile, Light l) {
  vec3 center = tile.view.worldToView * vec4(l.position, 1.0);
  float depth = kLens != 0u ? length(center) : center.y;
  float reach = l.radius + 1e-4 * (l.radius + abs(center.x) + abs(depth) + abs(center.z));
  uint a = keyAt(tile.view.projection, depth - reach), b = keyAt(tile.view.projection, depth + reach);
  uint near = min(max(a, b), tile.slices.x), far = min(a, b);
  uint mask = (0xffffffffu << sliceOf(near, tile.slices)) & (0xffffffffu >> (31u - sliceOf(far, tile.slices)));
  bool reaches = reachesTile(tile, center, reach) && far <= tile.slices.x;
  return reaches ? mask : 0u;
}

// Returns true if the light may reach the cell. Branch-free to keep control flow uniform: subgroup votes follow, and
// diverged lanes are not guaranteed to have reconverged by then.
bool listed(Tile tile, Cell cell, Light l) {
  vec3 d = max(max(cell.low - l.position, l.position - cell.high), vec3(0.0));
  bool near = dot(d, d) < l.radius * l.radius;
  bool inCone = coneReaches(l, cell.low, cell.high);
  bool inSlices = true;
  if (kCellsPerTile == 1u) inSlices = (slicesReached(tile, l) & cell.slices) != 0u;
  bool aimed = !lightHasCone(l.type) || inCone;
  return near && aimed && inSlices;
}

// --- lists ----------------------------------------------------------------------------------------------------------

// Appends the lights that reach the cell to the tile's entries and returns their number. On overflow it stops early and
// returns a number larger than the remaining capacity.
uint appendList(Tile tile, Cell cell, FrameConstants frame) {
  EntriesRef entries = EntriesRef(push.lists.entries + uint64_t(tile.index) * (4u * kEntriesPerTile));
  uint count = 0u, leaf;
  TreeWalk walk = startWalk(frame, cell.low, cell.high, true);
  while (count <= kEntriesPerTile - tile.used && nextLeaf(walk, frame, leaf)) {
    for (uint first = 0u; first < kLightTreeWidth; first += lanesPresent) {
      uint light = leaf + first + laneRank;
      Light l = frameLight(frame, min(light, frame.lightCount - 1u));
      bool hit = first + laneRank < kLightTreeWidth && light < frame.lightCount && listed(tile, cell, l);
      uvec4 hits = subgroupBallot(hit);
      uint place = tile.used + count + subgroupBallotExclusiveBitCount(hits);
      if (hit && place < kEntriesPerTile) entries.v[place] = light;
      count += subgroupBallotBitCount(hits);
    }
  }
  return count;
}

void listTile(inout Tile tile, FrameConstants frame) {
  CellsRef cells = CellsRef(push.lists.cells + uint64_t(tile.index) * (8u * (kCellsPerTile + 1u)));
  cells.v[0] = tile.slices;  // every lane writes the same value
  uint pending = kCellsPerTile == 1u ? 1u : tile.occupied;
  while (pending != 0u) {
    uint slice = uint(findLSB(pending));
    pending &= pending - 1u;
    Cell cell = cellOf(tile, frame, kCellsPerTile == 1u ? tile.occupied : 1u << slice);
    uint count = appendList(tile, cell, frame);
    bool fits = count <= kEntriesPerTile - tile.used;
    cells.v[1u + slice] = uvec2(tile.used, fits ? count : kOverflow);
    if (fits) tile.used += count;
  }
}

void main() {
  countLanes();
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  for (uint i = gl_SubgroupID; i < kTilesPerGroup; i += gl_NumSubgroups) {
    uvec2 place = uvec2(gl_WorkGroupID.x * kTilesPerGroup + i, gl_WorkGroupID.y);
    if (place.x >= push.lists.tiles.x) break;
    Tile tile;
    tile.layer = gl_WorkGroupID.z;
    tile.view = frameView(frame, tile.layer);
    tile.corner = place * kTileSize;
    tile.index = tileOf(uvec3(place, tile.layer), push.lists.tiles);
    tile.used = 0u;
    if (findSlices(tile)) listTile(tile, frame);
  }
}
