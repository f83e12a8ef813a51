// Push constants of the shaders of `latelight bench rays`.
#ifndef LATELIGHT_STUDY_BENCH_RAYS_PUSH_H
#define LATELIGHT_STUDY_BENCH_RAYS_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct BenchRay {  // in the device's world space
  vec3 origin;
  float near;  // meters; above `far`: the ray is not used
  vec3 direction;
  float far;
};
SH_CONST uint kBenchRayBytes = 32u;

struct BenchHit {
  float distance;  // meters; infinite: nothing is hit
  uint instance;   // index in FrameConstants::instances
  uint triangle;   // index in the mesh
  uint padding;
};

SH_CONST uint kBenchRow = 65536u;  // invocations per row of a dispatch

// The values of BenchSourcesPush::kind.
SH_CONST uint kPrimaryRays = 0u;
SH_CONST uint kDiffuseRays = 1u;
SH_CONST uint kLightRays = 2u;

struct BenchSourcesPush {
  uint64_t frame;    // FrameConstants
  uint64_t primary;  // BenchRay[count]
  uint64_t hits;     // BenchHit[count]: what the primary rays hit
  uint64_t rays;     // BenchRay[count], written
  uint64_t used;     // uint: the number of rays that are used, in addition
  // The ray through a point of the image, whose coordinates x and y are from -1 to 1, y up: `across` and `up` times x
  // and y are added to the direction, or to the origin.
  vec3 origin, direction;
  vec3 across, up;
  uint orthographic;  // 1: to the origin
  uint width;         // pixels, a multiple of 8
  uint height;        // pixels, a multiple of 4
  uint count;
  uint kind;
};

struct BenchRaysPush {
  uint64_t frame;  // FrameConstants
  uint64_t rays;   // BenchRay[count]
  uint64_t hits;   // BenchHit[count], written
  uint count;
};

SH_END

#endif
