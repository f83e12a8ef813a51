// Packs data outputs where a pixel's surface is resolved: the values that the layout `exact` would store, without an
// intermediate G-buffer. Include before the layout that the shader is compiled for.
#ifndef LATELIGHT_SURFACE_OUTPUTS_GLSL
#define LATELIGHT_SURFACE_OUTPUTS_GLSL
#include "render/outputs/exact_targets.glsl"
#include "render/outputs/pack.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer OutputSlotsRef { OutputSlot v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer OutputBitsRef { uint v[]; };

#define OUTPUT_SLOTS(SLOT)                                                                                   \
  SLOT(0) SLOT(1) SLOT(2) SLOT(3) SLOT(4) SLOT(5) SLOT(6) SLOT(7) SLOT(8) SLOT(9) SLOT(10) SLOT(11) SLOT(12) \
  SLOT(13) SLOT(14) SLOT(15) SLOT(16) SLOT(17) SLOT(18) SLOT(19) SLOT(20) SLOT(21) SLOT(22) SLOT(23)
// surfaceOutputBits() of each slot
#define OUTPUT_CONSTANT(i) layout(constant_id = kFirstOutputConstant + i) const uint kOutput##i = 0u;
OUTPUT_SLOTS(OUTPUT_CONSTANT)
const bool kPacksOutputs = kOutput0 != 0u;  // slots are filled from the first one on

// `frame`: FrameConstants.
void writeOutput(uint64_t frame, View view, OutputSlot place, uint bits, ExactTargets targets, float depth, ivec3 pixel,
                 int width) {
  SurfaceOutput o = surfaceOutputOf(bits);
  uvec4 found = targets.v[o.target], values;
  for (uint i = 0u; i < 4u; ++i) values[i] = found[min(o.first + i, 3u)];
  if (o.second != kPackOneTarget) values.y = targets.v[o.second][o.secondFirst];
  if (o.packing == kPackDepth || o.packing == kPackDistance)
    values.x = floatBitsToUint(packedMetres(frame, view, o.packing, depth, pixel));
  if (o.packing == kPackPosition) values.xyz = floatBitsToUint(packedPosition(frame, uintBitsToFloat(values.xyz)));
  if (o.packing == kPackNormal || o.packing == kPackPosition)
    values.xyz = floatBitsToUint(packedInAxes(view, o.axes, uintBitsToFloat(values.xyz)));
  OutputBitsRef to = OutputBitsRef(place.values + uint64_t(pixel.z) * place.viewBytes);
  uint at = (pixel.y * width + pixel.x) * o.channels;
  for (uint i = 0u; i < o.channels; ++i) to.v[at + i] = values[i];
}

// Writes the outputs whose slots are push constants.
void writePushedOutputs(uint64_t frame, View view, OutputSlot slots[kPackedAtOnce], ExactTargets targets, float depth,
                        ivec3 pixel, int width) {
#define PUSHED_WRITE(i) \
  if (kOutput##i != 0u) writeOutput(frame, view, slots[i], kOutput##i, targets, depth, pixel, width);
  PUSHED_WRITE(0) PUSHED_WRITE(1) PUSHED_WRITE(2) PUSHED_WRITE(3) PUSHED_WRITE(4) PUSHED_WRITE(5)
}

void writeOutputs(uint64_t frame, View view, uint64_t places, ExactTargets targets, float depth, ivec3 pixel,
                  int width) {
#define OUTPUT_WRITE(i) \
  if (kOutput##i != 0u) writeOutput(frame, view, OutputSlotsRef(places).v[i], kOutput##i, targets, depth, pixel, width);
  OUTPUT_SLOTS(OUTPUT_WRITE)
}

#endif
