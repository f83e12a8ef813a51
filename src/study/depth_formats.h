// The round trip of a device depth through a format or packing, in GLSL and C++.
#ifndef LATELIGHT_STUDY_DEPTH_FORMATS_H
#define LATELIGHT_STUDY_DEPTH_FORMATS_H

#include "shared/depth_packing.h"
#include "shared/unorm.h"

SH_BEGIN

SH_CONST uint kDepth32 = 0u;  // float
SH_CONST uint kDepth24 = 1u;  // UNORM
SH_CONST uint kDepth16 = 2u;
SH_CONST uint kDepthRgba8 = 3u;
SH_CONST uint kDepthRgba8Classic = 4u;

SH_FUNC vec4 throughBytes(vec4 e) {
  return vec4(unormValue(unormCode(e.x, 255.0f), 255.0f), unormValue(unormCode(e.y, 255.0f), 255.0f),
              unormValue(unormCode(e.z, 255.0f), 255.0f), unormValue(unormCode(e.w, 255.0f), 255.0f));
}

SH_FUNC float storedDepth(uint format, float depth) {
  if (format == kDepth24) return unormValue(unormCode(depth, 16777215.0f), 16777215.0f);
  if (format == kDepth16) return unormValue(unormCode(depth, 65535.0f), 65535.0f);
  if (format == kDepthRgba8) return unpackDepth(throughBytes(packDepth(depth)));
  if (format == kDepthRgba8Classic) return unpackDepthClassic(throughBytes(packDepthClassic(depth)));
  return depth;
}

SH_END

#endif
