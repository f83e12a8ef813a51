// The contents of a G-buffer layout file (shared/gbuffer/<name>.h):
//
//   #define GBUFFER_DESCRIPTION "one line for `latelight list layouts`"
//   #define GBUFFER_FIXED_NORMAL "how"        if its normals have a form of their own and ignore the normal encoding
//   #define GBUFFER_FIXED_POSITION "how"      if it keeps positions and has no use for the position method
//   #define GBUFFER_SUN_TARGET index          if the alpha of that target is the sun's shadow, filled after geometry
//   #define GBUFFER_DEPTH_FORMAT FORMAT       if the design it follows has another depth buffer or light accumulation
//   #define GBUFFER_LIGHT_FORMAT FORMAT       target than frames here have: what it cost there follows from them
//   #define GBUFFER_TARGETS(T) T(index, name, FORMAT, type, "what is in each channel") ...
//   GBUFFER_BEGIN
//   SH_FUNC GbufferTexel packGbuffer(Surface s, GbufferContext c)    one member a target, named as in GBUFFER_TARGETS
//   SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c)
//   GBUFFER_END
//
// FORMAT is a Vulkan format without VK_FORMAT_, or NORMAL32: four bytes that follow the normal encoding (R16G16_UNORM
// for two channels, A2B10G10R10_UNORM for three); packNormal32 and unpackNormal32 go with it. `type` is vec4 for float
// and normalised formats, uvec2 or uvec4 for integer ones, uint for R32_UINT. The fragment outputs, sampled inputs,
// Vulkan formats, bytes a pixel, debug names and the C++ registry all follow from this list; nothing else names a
// layout.
//
// A layout without targets defines GBUFFER_NO_TARGETS and an empty GBUFFER_TARGETS, and neither packs nor unpacks:
// surfaces are found again wherever they are needed (render/visibility/compute/shown_surface.glsl).
//
// A layout that stores Surface::motion defines GBUFFER_KEEPS_MOTION; for the others it is not computed.
//
// A layout that stores Surface::flags defines GBUFFER_KEEPS_FLAGS; for the others unlit surfaces reflect nothing (their
// base colour is already in the light accumulation target).
//
// In addition to its targets every layout has the depth buffer (D32_SFLOAT, reversed) and the frame's light
// accumulation target (RGBA16F): emitted radiance in rgb, and ambient occlusion in alpha for the layouts that have no
// room for it.
#ifndef LATELIGHT_SHARED_GBUFFER_H
#define LATELIGHT_SHARED_GBUFFER_H

#include "normals.h"
#include "shared/color.h"
#include "shared/lang.h"
#include "shared/projection.h"
#include "shared/surface.h"
#include "shared/types.h"

#define GBUFFER_MEMBER(index, name, format, type, channels) type name;
#if defined(__cplusplus)
// Each layout has a namespace of its own, named by the source file compiled for it.
#define GBUFFER_BEGIN                   \
  SH_BEGIN namespace LATELIGHT_LAYOUT { \
    struct GbufferTexel {               \
      GBUFFER_TARGETS(GBUFFER_MEMBER)   \
    };
#define GBUFFER_END \
  }                 \
  SH_END
#else
#define GBUFFER_BEGIN               \
  struct GbufferTexel {             \
    GBUFFER_TARGETS(GBUFFER_MEMBER) \
  };
#define GBUFFER_END
#endif

SH_BEGIN

struct GbufferContext {
  View view;
  vec2 pixel;           // picture coordinates of the sample, y down, centres at .5
  float depth;          // device depth; unpacking only
  float ao;             // from the light accumulation target; unpacking only
  uint normalEncoding;  // kNormal_*
  uint normalSpace;     // kNormalSpace*
  uint positionMethod;  // kPosition*
};

// World position of the sample, from its depth.
SH_FUNC vec3 positionFromDepth(GbufferContext c) {
  vec3 v = viewPosition(c.view.projection, c.positionMethod, pixelToNdc(c.pixel, c.view.size), c.depth);
  return c.view.viewToWorld * vec4(v, 1.0f);
}

SH_FUNC vec3 rotateToView(View view, vec3 n) {
  return view.worldToView * vec4(n, 0.0f);
}
SH_FUNC vec3 rotateToWorld(View view, vec3 n) {
  return view.viewToWorld * vec4(n, 0.0f);
}

// Unit direction from a world position to the eye; the same everywhere for an orthographic view.
SH_FUNC vec3 directionToEye(View view, vec3 position) {
  if (view.projection.kind == kPerspective) return normalize(view.eye - position);
  return rotateToWorld(view, vec3(0.0f, -1.0f, 0.0f));
}

// A value in [0, 1] as an integer of `bits` bits, round to nearest, and back.
SH_FUNC uint toBits(float x, uint bits) {
  return uint(saturate(x) * float((1u << bits) - 1u) + 0.5f);
}
SH_FUNC float fromBits(uint x, uint bits) {
  return float(x & ((1u << bits) - 1u)) / float((1u << bits) - 1u);
}

// --- normals --------------------------------------------------------------------------------------------------------

// The space a layout encodes normals in. Encodings are most accurate at +Z; in view space that is towards the viewer:
// (x, z, -y) of X right, Y away, Z up.
SH_CONST uint kNormalSpaceLayout = 0u;  // the layout's own
SH_CONST uint kNormalSpaceWorld = 1u;
SH_CONST uint kNormalSpaceView = 2u;

// An encoding without the far hemisphere can be used in view space only. `layoutSpace`: the layout's own.
SH_FUNC bool normalsInViewSpace(GbufferContext c, uint layoutSpace) {
  if (normalHemisphereOnly(c.normalEncoding)) return true;
  return (c.normalSpace == kNormalSpaceLayout ? layoutSpace : c.normalSpace) == kNormalSpaceView;
}

// A unit world normal to the frame in which it is encoded, and back.
SH_FUNC vec3 toNormalSpace(GbufferContext c, uint layoutSpace, vec3 n) {
  if (!normalsInViewSpace(c, layoutSpace)) return n;
  vec3 v = rotateToView(c.view, n);
  return vec3(v.x, v.z, -v.y);
}
SH_FUNC vec3 fromNormalSpace(GbufferContext c, uint layoutSpace, vec3 n) {
  if (!normalsInViewSpace(c, layoutSpace)) return n;
  return rotateToWorld(c.view, vec3(n.x, -n.z, n.y));
}

// A normal for a NORMAL32 target, and back.
SH_FUNC vec3 normal32Levels(uint encoding) {
  float levels = normalChannels(encoding) == 2u ? 65535.0f : 1023.0f;
  return vec3(levels, levels, levels);
}
SH_FUNC vec4 packNormal32(GbufferContext c, uint layoutSpace, vec3 n) {
  vec3 e = encodeNormal(c.normalEncoding, toNormalSpace(c, layoutSpace, n), normal32Levels(c.normalEncoding));
  return vec4(e.x, e.y, e.z, 0.0f);
}
SH_FUNC vec3 unpackNormal32(GbufferContext c, uint layoutSpace, vec4 texel) {
  vec3 n = decodeNormal(c.normalEncoding, vec3(texel.x, texel.y, texel.z), normal32Levels(c.normalEncoding));
  return fromNormalSpace(c, layoutSpace, n);
}

// A normal in 24 bits: 12 + 12 for encodings of two channels, 8 + 8 + 8 for three.
SH_FUNC uint packNormal24(uint encoding, vec3 n) {
  bool two = normalChannels(encoding) == 2u;
  uint bits = two ? 12u : 8u;
  float levels = float((1u << bits) - 1u);
  vec3 e = encodeNormal(encoding, n, vec3(levels, levels, levels));
  uint packed = toBits(e.x, bits) | (toBits(e.y, bits) << bits);
  return two ? packed : packed | (toBits(e.z, bits) << (2u * bits));
}
SH_FUNC vec3 unpackNormal24(uint encoding, uint packed) {
  bool two = normalChannels(encoding) == 2u;
  uint bits = two ? 12u : 8u;
  float levels = float((1u << bits) - 1u);
  vec3 e = vec3(fromBits(packed, bits), fromBits(packed >> bits, bits), two ? 0.0f : fromBits(packed >> 16u, 8u));
  return decodeNormal(encoding, e, vec3(levels, levels, levels));
}

// --- colours --------------------------------------------------------------------------------------------------------

// Linear colour to sRGB, 8 bits a channel.
SH_FUNC uint packColor24(vec3 c) {
  return toBits(srgbFromLinear(saturate(c.x)), 8u) | (toBits(srgbFromLinear(saturate(c.y)), 8u) << 8u) |
         (toBits(srgbFromLinear(saturate(c.z)), 8u) << 16u);
}
SH_FUNC vec3 unpackColor24(uint packed) {
  return vec3(linearFromSrgb(fromBits(packed, 8u)), linearFromSrgb(fromBits(packed >> 8u, 8u)),
              linearFromSrgb(fromBits(packed >> 16u, 8u)));
}

SH_END

#endif
