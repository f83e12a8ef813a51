// What shaders are told of outputs on their way out: those that pack targets, and those that pack surfaces.
#ifndef LATELIGHT_RENDER_OUTPUTS_PACK_PUSH_H
#define LATELIGHT_RENDER_OUTPUTS_PACK_PUSH_H

#include "shared/lang.h"

SH_BEGIN

struct PackPush {
  uint64_t frame;      // FrameConstants; of kPackDepth, kPackDistance, and of axes of the camera
  uint64_t values;     // float[height][width][channels] of a view, or uint of ids
  uint64_t viewBytes;  // from one view to the next
  uint packing;        // kPack*
  uint channels;       // that leave
  uint first;          // of the first image's channels
  uint second;         // of the second image's: where half of the channels are; kPackOneImage: all are in the first
  uint axes;           // kAxes*
  float scale;         // of kPackValues
};

SH_CONST uint kPackOneImage = 255u;

SH_CONST uint kPackValues = 0u;    // as they are
SH_CONST uint kPackDepth = 1u;     // metres along the view axis from device depth
SH_CONST uint kPackDistance = 2u;  // metres along the pixel's ray, likewise
SH_CONST uint kPackNormal = 3u;    // a direction, by the axes that normals are asked in
SH_CONST uint kPackPosition = 4u;  // by the axes of the world
SH_CONST uint kPackCount = 5u;     // surfaces of a pixel (kSurfacesFormat); of depth, 1 where something is drawn

SH_CONST uint kAxesWorld = 0u;
SH_CONST uint kAxesGltf = 1u;    // the world's as in a glTF file
SH_CONST uint kAxesOpenCv = 2u;  // the camera's: X right, Y down, Z forward
SH_CONST uint kAxesOpenGl = 3u;  // the camera's: X right, Y up, Z back

// Of an output that is packed where surfaces are resolved (surface_outputs.glsl): where it goes.
struct OutputPlace {
  uint64_t values;  // as PackPush
  uint64_t viewBytes;
};

// And what it is, as a specialization constant; 0: no output. Its channels begin in one of the layout `exact`'s
// targets, or half of them in each of two.
SH_CONST uint kSurfaceOutputs = 24u;  // at most: the slots of surface_outputs.glsl
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
#endif

#endif
