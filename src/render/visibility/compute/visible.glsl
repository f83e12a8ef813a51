// The visibility buffer: 64 bits a sample, device depth above the number of the triangle; 0 where nothing shows. The
// number is the larger the later a triangle is drawn, so that the largest value is what shows, of equal depths the last.
#ifndef LATELIGHT_VISIBLE_GLSL
#define LATELIGHT_VISIBLE_GLSL
#include "render/glsl/samples.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer VisibleRef { uint64_t v[]; };

// `pixel`: of a view, and which view; `size`: of all of them.
uint pixelIndex(uvec3 pixel, uvec2 size) { return (pixel.z * size.y + pixel.y) * size.x + pixel.x; }
// Of its first sample; the others follow.
uint visibleIndex(uvec3 pixel, uvec2 size) { return pixelIndex(pixel, size) * kSamples; }

uint64_t visibleValue(float depth, uint id) { return uint64_t(floatBitsToUint(depth)) << 32 | uint64_t(id); }
float visibleDepth(uint64_t visible) { return uintBitsToFloat(uint(visible >> 32)); }
uint visibleId(uint64_t visible) { return uint(visible); }

#endif
