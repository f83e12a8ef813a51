// Structs that shaders which read the arrays of worlds (WorldArray in worlds.h) share with the host.
#ifndef LATELIGHT_WORLD_INPUTS_PUSH_H
#define LATELIGHT_WORLD_INPUTS_PUSH_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kPlaceGroup = 64u;          // invocations per workgroup
SH_CONST uint kPlaceColumns = 1u << 20u;  // invocations per z slice, because the workgroups per axis are limited
SH_CONST uint kNowhere = 4294967295u;     // an index of nothing

// A flag of Instance::flags, in addition to those of shared/types.h: the world does not have the instance, or it is
// hidden.
SH_CONST uint kInstanceAbsent = 16u;

// The elements of an array that a caller gave.
SH_CONST uint kNumberFloat = 0u;
SH_CONST uint kNumberDouble = 1u;
SH_CONST uint kNumberInt = 2u;   // 32 bits
SH_CONST uint kNumberLong = 3u;  // 64 bits

// An array of matrices or of single numbers that a caller gave: [worlds][elements][rows][columns], without padding.
struct WorldNumbers {
  uint64_t address;  // 0: not given
  uint rows;         // of each matrix of 4 columns; with 3 rows, the last one is 0 0 0 1
  uint element;      // kNumber*
};

// The state of a world after its values were read, as bits. The first four make it invalid: it has no instances.
SH_CONST uint kWorldNotFinite = 1u;
SH_CONST uint kWorldWrongTransform = 2u;   // its last row is not 0 0 0 1
SH_CONST uint kWorldWrongPose = 4u;        // not a rotation and a translation
SH_CONST uint kWorldWrongIntrinsics = 8u;  // of a camera matrix
SH_CONST uint kWorldInvalid = 15u;
SH_CONST uint kWorldWrongRide = 16u;          // a camera rides on an instance without a frame (mirrored or sheared)
SH_CONST uint kWorldVast = 32u;               // has instances with kInstanceVast
SH_CONST uint kWorldWrongFactors = 64u;       // of a material: below 0, or above 1 for metallic and roughness
SH_CONST uint kWorldWrongEnvironment = 128u;  // its intensity is below 0
SH_CONST uint kWorldWrongChoice = 256u;       // of a material: not an index in the palette
SH_CONST uint kWorldWrongEnvironmentIndex = 2048u;
SH_CONST uint kWorldWrongLight = 512u;       // a color or intensity below 0
SH_CONST uint kWorldWrongDirection = 1024u;  // of a light: its length is 0
SH_CONST uint kWorldWrongJoint = 4096u;      // the last row of its transform is not 0 0 0 1

SH_END

#endif
