#version 460
#extension GL_GOOGLE_include_directive : require
// Bounds of all instances of a world at rest, with one workgroup per world. The host's counterpart is
// scene::addBounds().
#include "render/visibility/compute/place_worlds.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) writeonly buffer BoundsOut { double v[]; };

shared dvec3 lows[kPlaceGroup], highs[kPlaceGroup];

// As the host's product of a matrix and a vector, which adds the columns in pairs.
dvec3 cornerInWorld(dmat4 m, dvec3 p) {
  precise dvec3 first = m[0].xyz * p.x + m[1].xyz * p.y, second = m[2].xyz * p.z + m[3].xyz;
  precise dvec3 sum = first + second;
  return sum;
}

void main() {
  WorldJob job = JobRef(push.job).v;
  uint world = workgroupIndex();
  if (world >= job.worlds) return;
  const double kInfinity = packDouble2x32(uvec2(0u, 0x7ff00000u));
  dvec3 low = dvec3(kInfinity), high = -low;
  bool invalid = isInvalid(job, world);
  for (uint i = gl_LocalInvocationIndex; i < job.instanceCount && !invalid; i += kPlaceGroup) {
    WorldTemplate t = templateOf(job, world, i);
    bool shown = (t.state & kTemplateHidden) == 0u && all(lessThanEqual(t.low, t.high)) && exists(job, world, t.place);
    if (!shown) continue;
    dmat4 toWorld = worldTransform(job, world, i, 0u);
    for (uint corner = 0u; corner < 8u; ++corner) {
      vec3 p = vec3((corner & 1u) != 0u ? t.high.x : t.low.x, (corner & 2u) != 0u ? t.high.y : t.low.y,
                    (corner & 4u) != 0u ? t.high.z : t.low.z);
      dvec3 at = cornerInWorld(toWorld, dvec3(p));
      low = min(low, at);
      high = max(high, at);
    }
  }
  lows[gl_LocalInvocationIndex] = low;
  highs[gl_LocalInvocationIndex] = high;
  barrier();
  if (gl_LocalInvocationIndex != 0u) return;
  for (uint i = 1u; i < kPlaceGroup; ++i) {
    low = min(low, lows[i]);
    high = max(high, highs[i]);
  }
  dvec3 origin = columnsAt(job.matrices, kDeviceOrigin)[0].xyz;
  low = difference(low, origin);
  high = difference(high, origin);
  for (uint axis = 0u; axis < 3u; ++axis) {
    BoundsOut(job.bounds).v[6u * world + axis] = low[axis];
    BoundsOut(job.bounds).v[6u * world + 3u + axis] = high[axis];
  }
}
