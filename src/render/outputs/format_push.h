// Parameters of format.comp.
#ifndef LATELIGHT_RENDER_OUTPUTS_FORMAT_PUSH_H
#define LATELIGHT_RENDER_OUTPUTS_FORMAT_PUSH_H

#include "shared/lang.h"

SH_BEGIN

SH_CONST uint kFormatGroup = 64u;  // invocations per workgroup

SH_CONST uint kFormatByte = 0u;   // channels of 8-bit RGBA
SH_CONST uint kFormatHalf = 1u;   // floats as half floats
SH_CONST uint kFormatShort = 2u;  // ids in 16 bits; larger ids become 65535
SH_CONST uint kFormatWord = 3u;   // 32 bits, unchanged

struct FormatPush {
  uint64_t source;  // packed pixels: RGBA8 words, or floats or ids [kSourceChannels]
  uint64_t sourceViewBytes;
  uint64_t target;  // first row of the first view, a multiple of the size of an element
  uint64_t targetViewBytes;
  uint64_t planeBytes;  // stride between channel planes, if planar
  uint elements;        // of a view, or of a plane if planar
  uint stride;          // words between those of an invocation
};

SH_END

#endif
