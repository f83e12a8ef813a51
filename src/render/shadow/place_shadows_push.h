// Structs of the shaders that fit the shadow maps of worlds on the device, shared with the host (placed_shadows.h).
#ifndef LATELIGHT_PLACE_SHADOWS_PUSH_H
#define LATELIGHT_PLACE_SHADOWS_PUSH_H

#include "shared/types.h"

SH_BEGIN

SH_CONST uint kPlaceShadowsGroup = 64u;  // invocations per workgroup
SH_CONST uint kMaxCascades = 4u;         // of a directional light in a view

// A directional light that casts shadows: the values that are the same for all of its maps.
struct SunTemplate {
  View view;      // of a map
  ShadowMap map;  // as lookups read it
};

// Everything about the shadow maps of one frame graph's views, which are consecutive views of a call. Each view has
// kMaxCascades maps per light, of which it may use fewer: map (view * suns + sun) * kMaxCascades + cascade.
struct PlacedShadowJob {
  uint64_t suns;     // SunTemplate[suns]
  uint64_t axes;     // double[suns][9]: right, away and up
  uint64_t numbers;  // double[kMaxCascades]: shares of the farthest distance; double[viewsPerWorld][2]: near and far
  uint64_t bounds;   // double[worlds][6]: low and high corner of each world, in the device's world space
  uint64_t views;    // View[views]
  uint64_t frames;   // FrameConstants[views]
  // Results: per view and light, and per map.
  uint64_t table;      // LightShadow[]
  uint64_t maps;       // ShadowMap[]
  uint64_t mapViews;   // View[], with reversed depth
  uint64_t mapFrames;  // FrameConstants[]
  uint64_t targets;    // ShadowTarget[]
  uint64_t within;     // RasterMap[]
  uint64_t pages;      // uint[maps][rows]: bits of the pages to draw; 0 for unused maps
  uint sunCount, viewCount, firstView, viewsPerWorld;
  uint size;        // texels per side of a map
  uint rows;        // of pages of a map
  uint mapsAtOnce;  // maps that are rasterized together
  uint across;      // maps per row of a layer of the atlas, which has as many rows
};

struct PlaceShadowsPush {
  uint64_t job;  // PlacedShadowJob
};

SH_END

#endif
