#version 460
#extension GL_GOOGLE_include_directive : require
// Packs data outputs from depth and from the words that geometry_data.frag wrote (pack_surfaces.glsl).
#include "render/glsl/common.glsl"
#include "shared/surface.h"
#include "render/outputs/data_words.glsl"
#include "render/outputs/surface_outputs.glsl"
#include "render/outputs/pack_surfaces.glsl"

// Binding i + 1 holds the words kDataWords<i>.
#define DATA_IMAGE(i) layout(set = 0, binding = i + 1) uniform usampler2DArray dataImage##i;
DATA_IMAGE(0) DATA_IMAGE(1) DATA_IMAGE(2) DATA_IMAGE(3) DATA_IMAGE(4) DATA_IMAGE(5)

ExactTargets packedTargets(ivec3 pixel) {
  ExactTargets targets = noTargets();
#define FETCH_DATA(i) \
  if (kDataWords##i != kNoDataWords) setExactWords(targets, kDataWords##i, texelFetch(dataImage##i, pixel, 0));
  FETCH_DATA(0) FETCH_DATA(1) FETCH_DATA(2) FETCH_DATA(3) FETCH_DATA(4) FETCH_DATA(5)
  return targets;
}
