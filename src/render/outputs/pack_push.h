// Push constants of pack.comp and pack_ids.comp, and what they do with texels.
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

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::PackPush) == 48);
#endif

#endif
