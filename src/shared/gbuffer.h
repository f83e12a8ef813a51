// The contents of a G-buffer layout file (shared/gbuffer/<name>.h):
//
//   #define GBUFFER_DESCRIPTION "one line for `latelight list layouts`"
//   #define GBUFFER_FIXED_NORMAL "how"        if the layout ignores the normal encoding and stores normals its own way
//   #define GBUFFER_FIXED_POSITION "how"      if the layout stores positions and ignores the position method
//   #define GBUFFER_SUN_TARGET index          if that target's alpha is the sun's shadow, written after geometry
//   #define GBUFFER_DEPTH_FORMAT FORMAT       if the original design has another depth buffer or light accumulation
//   #define GBUFFER_LIGHT_FORMAT FORMAT       target than frames here; its original cost in bytes follows from them
//   #define GBUFFER_TARGETS(T) T(index, name, FORMAT, type, "what is in each channel") ...
//   GBUFFER_BEGIN
//   SH_FUNC GbufferTexel packGbuffer(Surface s, GbufferContext c)    one member per target, named as in GBUFFER_TARGETS
//   SH_FUNC Surface unpackGbuffer(GbufferTexel t, GbufferContext c)
//   GBUFFER_END
//
// FORMAT is a Vulkan format without VK_FORMAT_, or NORMAL32: four bytes that follow the normal encoding (R16G16_UNORM
// for two channels, A2B10G10R10_UNORM for three), packed and unpacked by packNormal32 and unpackNormal32. `type` is
// vec4 for float and normalized formats, uvec2 or uvec4 for integer ones, uint for R32_UINT. The fragment outputs,
// sampled inputs, Vulkan formats, bytes per pixel, debug names and the C++ registry all follow from this list; no other
// code names a layout.
//
// A layout without targets defines GBUFFER_NO_TARGETS and an empty GBUFFER_TARGETS, and neither packs nor unpacks:
// shaders evaluate surfaces from the visibility buffer instead (render/visibility/compute/visible_surface.glsl).
//
// A layout that stores Surface::motion defines GBUFFER_KEEPS_MOTION; motion is not computed for the others.
//
// A layout that stores Surface::flags defines GBUFFER_KEEPS_FLAGS. In the others, unlit surfaces reflect nothing (their
// base color is already in the light accumulation target).
//
// In addition to its targets, every layout has the depth buffer (D32_SFLOAT, reversed depth) and the frame's light
// accumulation target (RGBA16F): emitted radiance in rgb, and in alpha the ambient occlusion for layouts that cannot
// store it.
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
// Each layout has its own namespace. The source file that is compiled for the layout defines its name.
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
  vec2 pixel;           // image coordinates of the sample, y down, pixel centers at .5
  float depth;          // device depth; unpacking only
  float ao;             // from the light accumulation target; unpacking only
  uint normalEncoding;  // kNormal_*
  uint normalSpace;     // kNormalSpace*
  uint positionMethod;  // kPosition*
};

// World position of the sample, reconstructed from its depth.
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

// Unit direction from a world position to the eye; constant for an orthographic view.
SH_FUNC vec3 directionToEye(View view, vec3 position) {
  if (view.projection.kind == kPerspective) return normalize(view.eye - position);
  return rotateToWorld(view, vec3(0.0f, -1.0f, 0.0f));
}

// Quantizes a value in [0, 1] to an integer of `bits` bits, round to nearest, and back.
SH_FUNC uint toBits(float x, uint bits) {
  return uint(saturate(x) * float((1u << bits) - 1u) + 0.5f);
}
SH_FUNC float fromBits(uint x, uint bits) {
  return float(x & ((1u << bits) - 1u)) / float((1u << bits) - 1u);
}

// --- normals --------------------------------------------------------------------------------------------------------

// The space in which a layout encodes normals. Encodings are most accurate at +Z, which points toward the viewer in
// view space: (x, z, -y) of X right, Y away, Z up.
SH_CONST uint kNormalSpaceLayout = 0u;  // the layout's own
SH_CONST uint kNormalSpaceWorld = 1u;
SH_CONST uint kNormalSpaceView = 2u;

// True if normals are encoded in view space. Encodings of only the near hemisphere require it. `layoutSpace` is the
// layout's own choice.
SH_FUNC bool normalsInViewSpace(GbufferContext c, uint layoutSpace) {
  if (normalHemisphereOnly(c.normalEncoding)) return true;
  return (c.normalSpace == kNormalSpaceLayout ? layoutSpace : c.normalSpace) == kNormalSpaceView;
}

// Rotates a unit world normal to the frame in which it is encoded, and back.
SH_FUNC vec3 toNormalSpace(GbufferContext c, uint layoutSpace, vec3 n) {
  if (!normalsInViewSpace(c, layoutSpace)) return n;
  vec3 v = rotateToView(c.view, n);
  return vec3(v.x, v.z, -v.y);
}
SH_FUNC vec3 fromNormalSpace(GbufferContext c, uint layoutSpace, vec3 n) {
  if (!normalsInViewSpace(c, layoutSpace)) return n;
  return rotateToWorld(c.view, vec3(n.x, -n.z, n.y));
}

// Packs a normal for a NORMAL32 target, and back.
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

// Packs a normal into 24 bits: 12 + 12 for encodings of two channels, 8 + 8 + 8 for three.
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

// --- colors ---------------------------------------------------------------------------------------------------------

// Linear color to sRGB, 8 bits per channel, and back.
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
