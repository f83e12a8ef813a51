#version 460
#extension GL_GOOGLE_include_directive : require
// Packs data outputs that depend only on depth (pack_surfaces.glsl).
#include "render/glsl/common.glsl"
#include "shared/surface.h"
#include "render/outputs/surface_outputs.glsl"
#include "render/outputs/pack_surfaces.glsl"

ExactTargets packedTargets(ivec3 pixel) { return noTargets(); }
