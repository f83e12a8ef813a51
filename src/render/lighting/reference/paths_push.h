// Push constants of paths.comp.
#ifndef LATELIGHT_RENDER_LIGHTING_REFERENCE_PATHS_PUSH_H
#define LATELIGHT_RENDER_LIGHTING_REFERENCE_PATHS_PUSH_H

#include "render/visibility/compute/shown_push.h"
#include "shared/lang.h"

SH_BEGIN

// The specialization constant kPathsFromLightsConstant.
SH_CONST uint kPathsFromLights = 1u;       // paths find the lights' light on visible surfaces
SH_CONST uint kPathsFromEye = 2u;          // where coats or translucent surfaces are visible, paths start at the eye
SH_CONST uint kPathsFindTranslucent = 4u;  // rays find blended and transmissive surfaces

// The second surface of a path, and the light of one sample, for path_sharing.comp.
struct PathRecord {
  vec3 position;
  uint normal;       // shading normal, octahedral
  vec3 reflected;    // radiance by the Lambertian lobe, divided by its albedo
  uint plane;        // normal of the triangle, octahedral
  vec3 lit;          // light of a light: intensity times attenuation, which the specular lobe reflects
  uint toLight;      // its direction, octahedral
  vec3 scattered;    // the path's other light through the Lambertian lobe of the visible surface; without a filter, all
  float f90;         // Surface::f90
  vec3 mirrored;     // and through the specular lobe
  uint color[2];     // base color and metallic, as halves
  uint specular[2];  // reflectance of the dielectric at normal incidence and roughness, as halves
  uint flags;        // kRecord*
  // Radiance that third and later surfaces send to the second one, from the direction `onward` (octahedral), and the
  // density, 1/sr, with which the path chose it. 0: pixels do not share what the specular lobe reflects of it.
  vec3 received;
  uint onward;
  float lobeDensity;
};
SH_CONST uint kPathRecordBytes = 116u;
SH_CONST uint kRecordCovers = 1u;   // the path starts at the eye and found a surface
SH_CONST uint kRecordGlares = 2u;   // a metal reflects a lamp that is close: `lit` is of a highlight, small and bright
SH_CONST float kCloseRadii = 8.0f;  // distance at which a lamp is close, in radii of the lamp
// Minimum roughness of specular lobes of which pixels share `received`. Narrower ones send it toward few pixels.
SH_CONST float kMinSharedRoughness = 0.15f;

struct PathsPush {
  uint64_t frame;  // FrameConstants
  VisibleSurfacePush shown;
  uint64_t emitterSums;  // float[emitterStride]: running sums of the emitters' powers; with worlds, for each view
  uint64_t records;      // PathRecord[end - first][views][height][width]; 0: paths are not shared
  uint first, end;       // samples of this pass
  uint samples;          // of all passes
  uint firstPoint;       // index of the first sample's point in the pixels' sequences
  uint bounces;          // maximum number of surfaces after the visible one
  uint emitterStride;    // elements from one view to the next
  uint views;
  uint environment;  // of the pass: its index among the environments of worlds
};

SH_END

#endif
