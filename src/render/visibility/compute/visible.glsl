// The visibility buffer: 64 bits per sample, device depth above the triangle id; 0 is background. Depth is reversed and
// ids increase in draw order, so the maximum is the visible surface and, at equal depth, the triangle drawn last.
#ifndef LATELIGHT_VISIBLE_GLSL
#define LATELIGHT_VISIBLE_GLSL
#include "render/glsl/samples.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer VisibleRef { uint64_t v[]; };

// `pixel` is the position and the view; `size` is the size of every view.
uint pixelIndex(uvec3 pixel, uvec2 size) { return (pixel.z * size.y + pixel.y) * size.x + pixel.x; }
// Returns the index of the pixel's first sample; the others follow.
uint visibleIndex(uvec3 pixel, uvec2 size) { return pixelIndex(pixel, size) * kSamples; }

uint64_t visibleValue(float depth, uint id) { return uint64_t(floatBitsToUint(depth)) << 32 | uint64_t(id); }
float visibleDepth(uint64_t visible) { return uintBitsToFloat(uint(visible >> 32)); }
uint visibleId(uint64_t visible) { return uint(visible); }

#endif
