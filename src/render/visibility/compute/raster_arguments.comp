#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the workgroup counts of the next indirect dispatch: one workgroup per push.entries entries of a queue, or
// push.parts workgroups for each of these, in rows of kRasterRow.
#include "render/glsl/common.glsl"
#include "render/visibility/compute/raster_push.h"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { RasterArgumentsPush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CountersRef { RasterCounters v; };

void main() {
  CountersRef counters = CountersRef(push.counters);
  uint count = push.which == kQueueWork      ? counters.v.work
               : push.which == kQueueClipped ? counters.v.clipped
               : push.which == kQueueMedium  ? counters.v.medium
               : push.which == kQueueLarge   ? counters.v.large
                                             : counters.v.jobs;
  count = (min(count, push.capacity) + push.entries - 1u) / push.entries;
  counters.v.groups = uvec3(min(count, kRasterRow), (count + kRasterRow - 1u) / kRasterRow, push.parts);
}
