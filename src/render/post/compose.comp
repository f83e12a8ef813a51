#version 460
#extension GL_GOOGLE_include_directive : require
// The finished picture: tonemap, background colour, sRGB, 8 bits.
#include "render/glsl/common.glsl"
#include "shared/color.h"
#include "shared/tonemap.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(set = 0, binding = 0) uniform sampler2DArray picture;  // linear, premultiplied by alpha

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PixelsRef { uint v[]; };

struct ComposePush {
  uint64_t pixels;   // uint[layers * height * width]: R lowest
  float scale;       // 1 / number of accumulated frames
  uint tonemap;      // kTonemap*
  vec4 background;   // linear display colour; alpha 0: transparent
};
layout(push_constant, scalar) uniform Push { ComposePush push; };

void main() {
  ivec3 pixel = ivec3(gl_GlobalInvocationID);
  ivec3 size = textureSize(picture, 0);
  if (any(greaterThanEqual(pixel.xy, size.xy))) return;
  vec4 c = texelFetch(picture, pixel, 0) * push.scale;
  // PNG has straight alpha: the colour is that of the covered part alone.
  vec3 display = c.a > 0.0 ? tonemap(push.tonemap, c.rgb / c.a) : vec3(0.0);
  float alpha = c.a + push.background.a * (1.0 - c.a);
  if (alpha > 0.0) display = mix(push.background.rgb, display, c.a / alpha);
  vec4 code = vec4(srgbFromLinear(display.r), srgbFromLinear(display.g), srgbFromLinear(display.b), alpha);
  PixelsRef(push.pixels).v[(pixel.z * size.y + pixel.y) * size.x + pixel.x] = packUnorm4x8(code);
}
