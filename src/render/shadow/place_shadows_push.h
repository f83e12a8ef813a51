// Structs of the shaders that fit the shadow maps of worlds on the device, shared with the host (placed_shadows.h).
#ifndef LATELIGHT_PLACE_SHADOWS_PUSH_H
#define LATELIGHT_PLACE_SHADOWS_PUSH_H

#include "shared/types.h"

SH_BEGIN

SH_CONST uint kPlaceShadowsGroup = 64u;  // invocations per workgroup
SH_CONST uint kMaxCascades = 4u;         // of a directional light in a view
SH_CONST uint kMinPlacedTile = 32u;      // texels per side of the smallest maps of local lights

// A shadow map: the values that are the same in all views.
struct MapTemplate {
  View view;      // of the map
  ShadowMap map;  // as lookups read it
};

// A point or spot light that casts shadows.
struct LocalCaster {
  vec3 position;
  float radius;   // its reach, meters
  float size;     // radius of the light itself, in which nothing casts shadows
  uint maps;      // 1, or 6 for the faces of a cube
  uint firstMap;  // among the maps of a view
  uint padding;
};

// Maps of one size: consecutive ones, with layers of the atlas and pages of their own.
struct PlacedMaps {
  uint first, count;
  uint size;        // texels per side
  uint rows;        // of pages of a map
  uint mapsAtOnce;  // maps that are rasterized together
  uint across;      // maps per row of a layer of the atlas, which has as many rows
  uint firstLayer, firstRow;
};

// Everything about the shadow maps of one frame graph's views, which are consecutive views of a call. The first group
// has kMaxCascades maps per view and directional light, of which a view may use fewer: map (view * suns + sun) *
// kMaxCascades + cascade. Group 1 + i has the maps of local lights of size kMinPlacedTile << i, localMaps per view. A
// view uses those of one size per light.
struct PlacedShadowJob {
  uint64_t suns;      // MapTemplate[suns]
  uint64_t axes;      // double[suns][9]: right, away and up
  uint64_t locals;    // LocalCaster[locals]
  uint64_t faces;     // MapTemplate[sizes][localMaps]
  uint64_t tangents;  // double[locals]: of half the angle of their maps
  // PlacedCaster[worlds][suns + locals], which shaders have written: the lights' positions and directions in each
  // world, in place of those above. 0: the lights are the same in all worlds, and the columns of `table` are in their
  // order.
  uint64_t casters;
  uint64_t groups;   // PlacedMaps[1 + sizes]
  uint64_t numbers;  // double[kMaxCascades]: shares of the farthest distance; double[viewsPerWorld][2]: near and far
  uint64_t bounds;   // double[worlds][6]: low and high corner of each world, in the device's world space
  uint64_t views;    // View[views]
  uint64_t frames;   // FrameConstants[views]
  // Results: per view and light, and per map.
  uint64_t table;      // LightShadow[views][suns + locals]
  uint64_t maps;       // ShadowMap[]
  uint64_t mapViews;   // View[], with reversed depth
  uint64_t mapFrames;  // FrameConstants[]
  uint64_t targets;    // ShadowTarget[]
  uint64_t within;     // RasterMap[]
  uint64_t pages;      // uint[maps][rows]: bits of the pages to draw; 0 for unused maps
  uint sunCount, localCount, localMaps, sizes;
  uint viewCount, firstView, viewsPerWorld;
  uint padding;
};

struct PlaceShadowsPush {
  uint64_t job;  // PlacedShadowJob
};

SH_END

#endif
