// Parameters of the shaders that pack outputs, from targets (PackPush) or from resolved surfaces (SurfaceOutput).
#ifndef LATELIGHT_RENDER_OUTPUTS_PACK_PUSH_H
#define LATELIGHT_RENDER_OUTPUTS_PACK_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct PackPush {
  uint64_t frame;      // FrameConstants; for the camera's axes
  uint64_t values;     // float[height][width][channels] per view, or uint[height][width] for ids
  uint64_t viewBytes;  // stride between views
  uint channels;       // number of output channels
  uint first;          // first channel in the first image
  uint second;         // channel in the second image of the output's channel 1; kPackOneImage: the first image has all
  uint axes;           // kAxes*
  float scale;         // for kPackValues
};

SH_CONST uint kPackOneImage = 255u;

SH_CONST uint kPackValues = 0u;    // unchanged
SH_CONST uint kPackDepth = 1u;     // meters along the view axis, from device depth
SH_CONST uint kPackDistance = 2u;  // meters along the pixel's ray, from device depth
SH_CONST uint kPackNormal = 3u;    // a direction, in the axes requested for normals
SH_CONST uint kPackPosition = 4u;  // a position, in the axes of the world
SH_CONST uint kPackCount = 5u;     // surfaces per pixel (kSurfacesFormat); from depth, 1 if something is drawn
SH_CONST uint kPackVector = 6u;    // a displacement, in the axes of the world

SH_CONST uint kAxesWorld = 0u;
SH_CONST uint kAxesGltf = 1u;    // the world's axes as in a glTF file
SH_CONST uint kAxesOpenCv = 2u;  // the camera's: X right, Y down, Z forward
SH_CONST uint kAxesOpenGl = 3u;  // the camera's: X right, Y up, Z back

// The destination of an output that is packed where surfaces are resolved (surface_outputs.glsl).
struct OutputSlot {
  uint64_t values;  // as in PackPush
  uint64_t viewBytes;
};

// Parameters of the shaders that pack the outputs of pack_surfaces.glsl.
SH_CONST uint kPackedAtOnce = 6u;
struct PackSurfacesPush {
  uint64_t frame;    // FrameConstants
  uint64_t covered;  // CoveredTiles, if only these tiles are packed
  OutputSlot slots[kPackedAtOnce];
};

// The source of such an output, passed as a specialization constant (surfaceOutputBits()); 0: no output. Its channels
// are consecutive in one of the targets of the layout `exact`, or half of them are in each of two targets.
SH_CONST uint kSurfaceOutputs = 24u;  // maximum: the slots of surface_outputs.glsl
struct SurfaceOutput {
  uint packing, axes, channels, target, first, second, secondFirst;  // second: kPackOneTarget, or the other target
};
SH_CONST uint kPackOneTarget = 15u;

SH_FUNC uint surfaceOutputBits(SurfaceOutput o) {
  return 1u << 31 | o.packing | o.axes << 4 | o.channels << 8 | o.target << 12 | o.first << 16 | o.second << 20 |
         o.secondFirst << 24;
}
SH_FUNC SurfaceOutput surfaceOutputOf(uint bits) {
  SurfaceOutput o;
  o.packing = bits & 15u;
  o.axes = bits >> 4 & 15u;
  o.channels = bits >> 8 & 15u;
  o.target = bits >> 12 & 15u;
  o.first = bits >> 16 & 15u;
  o.second = bits >> 20 & 15u;
  o.secondFirst = bits >> 24 & 15u;
  return o;
}

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::PackPush) == 48);
static_assert(sizeof(latelight::shared::PackSurfacesPush) <= 128);
#endif

#endif
