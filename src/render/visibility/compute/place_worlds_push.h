// Structs that the shaders that place worlds on the device share with the host (world_placer.h).
#ifndef LATELIGHT_PLACE_WORLDS_PUSH_H
#define LATELIGHT_PLACE_WORLDS_PUSH_H

#include "render/deform/world_deform_push.h"
#include "render/gpu_scene/light_template_push.h"
#include "render/gpu_scene/world_inputs_push.h"
#include "shared/types.h"

SH_BEGIN

// An instance of the scene: its values that are the same in all worlds.
struct WorldTemplate {
  vec3 low, high;     // bounds of its mesh in object space, in its pose
  vec3 vertexOrigin;  // of its mesh
  float longestEdge;  // of its mesh, in object space
  uint mesh, material, id, part;
  uint flags;     // kInstanceExtras and the group
  uint place;     // among the instances that the caller's arrays describe, or kNowhere
  uint draw;      // draw index, or kNowhere
  uint state;     // kTemplateHidden, kTemplateTurnedOver
  uint deformed;  // among the meshes that worlds deform, or kNowhere; these have bounds of their own in each world
};
SH_CONST uint kTemplateHidden = 1u;
SH_CONST uint kTemplateTurnedOver = 2u;  // its skin mirrors the mesh

// The matrices of WorldJob::matrices, 4x4 and column by column.
SH_CONST uint kWorldFromFile = 0u;     // the renderer's world from the file's frame
SH_CONST uint kFileFromWorld = 1u;     // its inverse
SH_CONST uint kCameraFromOpenCv = 2u;  // right factor from a pose in OpenCV's axes to one in the renderer's
SH_CONST uint kDeviceOrigin = 3u;      // x, y, z of the device's origin, then padding
SH_CONST uint kWorldMatrices = 4u;

// Everything about one call. Times: 0 the current frame, 1 the previous and 2 the next one.
struct WorldJob {
  uint64_t matrices;         // double[kWorldMatrices][16]
  uint64_t templates;        // WorldTemplate[instances]
  uint64_t transforms;       // double[times][instances][16]: the scene's, column by column
  uint64_t rasterTemplates;  // RasterInstance[draws]
  uint64_t cameras;          // View[views per world]: projections of the scene's cameras
  uint64_t cameraPoses;      // double[views per world][16]: their poses in the renderer's world, column by column
  uint64_t rides;            // uint[views per world]: the instance on which the camera rides, or kNowhere; 0: none
  uint64_t materials;        // Material[]; from firstDerived on, results: [worlds][listed]
  uint64_t choices;          // uint[worlds][listed]: index of the material; 0: that of the template
  uint64_t palette;          // uint[paletteSize]: materials that `materialChoice` refers to
  uint64_t exists;           // one byte each: [worlds][listed]; 0: all exist
  uint64_t emptyWorlds;      // uint[worlds], not 0: the host knows that the world is invalid; 0: no such worlds
  uint64_t status;           // uint[worlds]: kWorld*, written by the shaders
  uint64_t instances[3];     // results, by time: Instance[worlds][instances]
  uint64_t bounds;           // result: double[worlds][6], low and high corner in the device's world space; 0: none
  uint64_t raster;           // result: RasterInstance[worlds][draws]
  uint64_t views[3];         // results, by time: View[worlds][views per world]
  WorldNumbers givenTransforms[3];                         // by time: 4x4 or 3x4 per listed instance
  WorldNumbers givenPoses[3];                              // by time: 4x4 or 3x4 per view
  WorldNumbers intrinsics;                                 // 3x3 per view
  WorldNumbers baseColor, metallic, roughness, emissive;   // 4, 1, 1 and 3 numbers per listed instance
  WorldNumbers materialChoice;                             // an integer per listed instance, an index in `palette`
  WorldNumbers environmentRotation, environmentIntensity;  // a number per world
  WorldNumbers environmentIndex;                           // an integer per world, an index in `environmentMaps`
  uint64_t environmentMaps;                                // uint[environments]: FrameConstants::environmentMap
  WorldNumbers lightPosition, lightDirection;              // 3 numbers per listed light
  WorldNumbers lightColor, lightIntensity;                 // 3 numbers and 1 per listed light
  uint64_t lightTemplates;                                 // LightTemplate[lights]
  uint64_t lightPositions;                                 // double[lights][kLightPositions]
  // Results, per world: Light[lights] in the order of the light tree, its LightBox[kPlacedLightBoxes], and
  // AreaLight[lights].
  uint64_t lightList, lightBoxes, areaLights;
  // If rays find the shadows of lights, results: Light[worlds][lights], in which these emit nothing, and
  // RayShadow[worlds][casters].
  uint64_t otherLights, rayShadows;
  // If shaders fit the shadow maps of these lights, results: PlacedCaster[worlds][mapCasters], and
  // ShadowBits[worlds][(lights + 31) / 32].
  uint64_t placedCasters, shadowBits;
  uint64_t bases;     // DerivableMaterial[] of the scene's materials
  uint64_t values;    // result: WorldValues[worlds]
  uint64_t deformed;  // DeformedBounds[worlds][deformedMeshes]
  uint worlds, instanceCount, listed, draws, viewsPerWorld;
  uint instanceTimes, viewTimes;  // 1 or 3: number of results
  uint width, height;             // of the images, pixels
  uint firstDerived;              // index of the first material that shaders derive, or kNowhere
  uint paletteSize, environments;
  uint lights, listedLights;           // numbers of templates, and of those that the caller's arrays describe
  uint casters, mapCasters;            // numbers of templates with kLightCastsByRays, and with shadow maps
  uint deformedMeshes, firstDeformed;  // number per world, and index of the first world's first mesh record
};

// A material of the scene, from which others are derived.
struct DerivableMaterial {
  uint flags;           // with kMaterialBlended as authored
  uint opaqueTextures;  // 1: with an alpha factor of 1, the material is opaque
};

struct PlacePush {
  uint64_t job;  // WorldJob
};

SH_END

#endif
