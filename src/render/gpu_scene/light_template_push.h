// Structs by which a shader writes the lights of worlds (visibility/compute/place_lights.comp), shared with the host.
#ifndef LATELIGHT_LIGHT_TEMPLATE_PUSH_H
#define LATELIGHT_LIGHT_TEMPLATE_PUSH_H

#include "shared/types.h"

SH_BEGIN

SH_CONST uint kLightAxisBits = 19u;     // of a Morton code, per axis
SH_CONST uint kMaxPlacedLights = 256u;  // of a world; more are converted on the host
SH_CONST uint kPlacedLightBoxes = kLightTreeWidth;

// A light of the scene: its values that are the same in all worlds.
struct LightTemplate {
  // As on the device: at rest, and in the pose of the call, which lights with a node follow unless a world moves them.
  // Area lights use the second list. Lights without extent have no radiance.
  Light light[2];
  AreaLight area[2];
  vec3 color;          // as authored
  float intensity;     // as authored
  vec3 fileDirection;  // at rest, in the file's frame
  uint listed;         // among the lights that the caller's arrays describe, or ~0
  uint radiusClass;    // of the light tree
  uint state;          // kLightIsArea, kLightHasNode, kLightHasExtent, kLightCastsByRays
  uint shadowRays;     // with kLightCastsByRays: values of RayShadow
  float shadowSize;
  uint mapCaster;  // index among the lights with shadow maps that shaders fit, or ~0
};
SH_CONST uint kLightIsArea = 1u;
SH_CONST uint kLightHasNode = 2u;
SH_CONST uint kLightHasExtent = 4u;  // area lights: they emit light if their radiance is not 0
SH_CONST uint kLightCastsByRays = 8u;
// Doubles per light: its positions at rest and in the pose of the call, in the renderer's world, and at rest in the
// file's frame.
SH_CONST uint kLightPositions = 9u;

// A light with shadow maps in a world. If it emits nothing there, only `column` is valid, and the others are harmless.
struct PlacedCaster {
  vec3 position;
  uint column;  // of FrameConstants::lightShadows, or kEmitsNothing
  vec3 direction;
  uint padding;
};
SH_CONST uint kEmitsNothing = 4294967295u;

SH_END

#endif
