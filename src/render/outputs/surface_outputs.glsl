// Packs data outputs where a pixel's surface is resolved: the values that the layout `exact` would store, without an
// intermediate G-buffer. Include before the layout that the shader is compiled for.
#ifndef LATELIGHT_SURFACE_OUTPUTS_GLSL
#define LATELIGHT_SURFACE_OUTPUTS_GLSL
#include "render/outputs/pack.glsl"

// Includes `exact` under its own names, because the shader's other layout may be `exact` as well.
#define GbufferTexel ExactTexel
#define packGbuffer packExact
#define unpackGbuffer unpackExact
#include "shared/gbuffer/exact.h"
#undef GbufferTexel
#undef packGbuffer
#undef unpackGbuffer
#undef LATELIGHT_SHARED_GBUFFER_EXACT_H

uvec4 exactBits(vec4 v) { return floatBitsToUint(v); }
uvec4 exactBits(uvec4 v) { return v; }

#define EXACT_COUNT(index, name, format, type, channels) +1
struct ExactTargets {
  uvec4 v[0 GBUFFER_TARGETS(EXACT_COUNT)];
};

ExactTargets noTargets() {
  ExactTargets targets;
  for (int i = 0; i < targets.v.length(); ++i) targets.v[i] = uvec4(0u);
  return targets;
}

ExactTargets exactTargets(Surface s) {
  GbufferContext anywhere;
  ExactTexel texel = packExact(s, anywhere);
  ExactTargets targets;
#define EXACT_BITS(index, name, format, type, channels) targets.v[index] = exactBits(texel.name);
  GBUFFER_TARGETS(EXACT_BITS)
  return targets;
}

#undef GBUFFER_KEEPS_FLAGS
#undef GBUFFER_DESCRIPTION
#undef GBUFFER_FIXED_NORMAL
#undef GBUFFER_FIXED_POSITION
#undef GBUFFER_TARGETS

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer OutputSlotsRef { OutputSlot v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer OutputBitsRef { uint v[]; };

#define OUTPUT_SLOTS(SLOT)                                                                                   \
  SLOT(0) SLOT(1) SLOT(2) SLOT(3) SLOT(4) SLOT(5) SLOT(6) SLOT(7) SLOT(8) SLOT(9) SLOT(10) SLOT(11) SLOT(12) \
  SLOT(13) SLOT(14) SLOT(15) SLOT(16) SLOT(17) SLOT(18) SLOT(19) SLOT(20) SLOT(21) SLOT(22) SLOT(23)
// surfaceOutputBits() of each slot
#define OUTPUT_CONSTANT(i) layout(constant_id = kFirstOutputConstant + i) const uint kOutput##i = 0u;
OUTPUT_SLOTS(OUTPUT_CONSTANT)
const bool kPacksOutputs = kOutput0 != 0u;  // slots are filled from the first one on

void writeOutput(uint64_t frame, OutputSlot place, uint bits, ExactTargets targets, float depth, ivec3 pixel,
                 int width) {
  SurfaceOutput o = surfaceOutputOf(bits);
  uvec4 found = targets.v[o.target], values;
  for (uint i = 0u; i < 4u; ++i) values[i] = found[min(o.first + i, 3u)];
  if (o.second != kPackOneTarget) values.y = targets.v[o.second][o.secondFirst];
  if (o.packing == kPackDepth || o.packing == kPackDistance)
    values.x = floatBitsToUint(packedMetres(frame, o.packing, depth, pixel));
  if (o.packing == kPackPosition) values.xyz = floatBitsToUint(packedPosition(frame, uintBitsToFloat(values.xyz)));
  if (o.packing == kPackNormal || o.packing == kPackPosition)
    values.xyz = floatBitsToUint(packedInAxes(frame, o.axes, uintBitsToFloat(values.xyz), pixel));
  OutputBitsRef view = OutputBitsRef(place.values + uint64_t(pixel.z) * place.viewBytes);
  uint at = (pixel.y * width + pixel.x) * o.channels;
  for (uint i = 0u; i < o.channels; ++i) view.v[at + i] = values[i];
}

void writeOutputs(uint64_t frame, uint64_t places, ExactTargets targets, float depth, ivec3 pixel, int width) {
#define OUTPUT_WRITE(i) \
  if (kOutput##i != 0u) writeOutput(frame, OutputSlotsRef(places).v[i], kOutput##i, targets, depth, pixel, width);
  OUTPUT_SLOTS(OUTPUT_WRITE)
}

#endif
