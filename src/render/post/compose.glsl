// Converts the linear picture to the finished one: tone mapping and background color, then sRGB and 8 bits.
#include "render/glsl/common.glsl"
#include "render/post/compose_push.h"
#include "shared/color.h"
#include "shared/tonemap.h"

layout(constant_id = kTonemapConstant) const uint kTonemap = 0u;  // kTonemap*
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PixelsRef { uint v[]; };

// Returns linear display color and straight alpha, as in PNG: the color is that of the covered part only. `c` is
// premultiplied.
vec4 displayColor(ComposePush push, vec4 c) {
  c *= push.scale;
  vec3 display = c.a > 0.0 ? tonemap(kTonemap, c.rgb / c.a) : vec3(0.0);
  float alpha = c.a + push.background.a * (1.0 - c.a);
  if (alpha > 0.0) display = mix(push.background.rgb, display, c.a / alpha);
  return vec4(display, alpha);
}

uint displayCode(vec4 display) {
  vec3 code = vec3(srgbFromLinear(display.r), srgbFromLinear(display.g), srgbFromLinear(display.b));
  uint packed = packUnorm4x8(vec4(code, display.a));
  return packed >> 24u != 0u ? packed : 0u;  // no color if alpha rounds to 0, for viewers that ignore alpha
}

void writeCode(ComposePush push, ivec3 place, ivec2 size, uint code) {
  PixelsRef view = PixelsRef(push.pixels + uint64_t(place.z) * push.viewBytes);
  view.v[place.y * size.x + place.x] = code;
}
