#version 460
#extension GL_GOOGLE_include_directive : require
// variants: layout, textured
// Visibility buffer resolve: evaluates the material of each visible triangle of a pixel once, and writes the G-buffer
// and data outputs (Burns and Hunt 2013, The Visibility Buffer: A Cache-Friendly Approach to Deferred Shading, JCGT
// 2(2)).
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/glsl/surface.glsl"
#include "render/outputs/surface_outputs.glsl"
#include "render/glsl/gbuffer_write.glsl"
#include "render/visibility/compute/visible.glsl"
#include "render/visibility/compute/pixel_triangles.glsl"
#include "render/glsl/redistribute.glsl"
#include "render/glsl/pixel_group.glsl"
#ifdef GBUFFER_KEEPS_MOTION
#include "render/visibility/compute/visible_motion.glsl"
#endif

layout(push_constant, scalar) uniform Push { ResolvePush push; };
// 1: surfaces with coats write no attributes.
layout(constant_id = kLayeredSeparatelyConstant) const uint kLayeredSeparately = 0u;

#include "render/visibility/resolve.glsl"

void packSurface(View view, Surface s, float depth, ivec3 pixel) {
  writeOutputs(push.frame, view, push.outputs, exactTargets(s), depth, pixel, int(view.size.x));
}

// Writes the G-buffer of the surface that these samples show, evaluated at their center.
void resolve(FrameConstants frame, View view, ivec3 pixel, uint samples) {
  uint index = visibleIndex(uvec3(pixel), uvec2(view.size)) + uint(findLSB(samples));
  uint64_t visible = VisibleRef(push.visible).v[index];
  uint id = visibleId(visible);
  ivec3 texel = sampleLayer(pixel, uint(findLSB(samples)));
  if (id == 0u) {
    store(texel, emptyTexel(), vec4(0.0));
    if (kPacksOutputs) writeOutputs(push.frame, view, push.outputs, noTargets(), 0.0, pixel, int(view.size.x));
    return;
  }
#ifndef TEXTURES_BY_INDEX
  textureRecords = frame.textures;
#endif
  vec2 place = vec2(pixel.xy) + sampleCentroid(samples);
  VisibleTriangle t = visibleTriangle(frame, push.instances, id);
  if (kLayeredSeparately != 0u && (t.draw.flags & kDrawLayered) != 0u) {
    store(texel, emptyTexel(), vec4(0.0, 0.0, 0.0, kShadedSeparately));
    return;
  }
  resolveTriangle(frame, view, pixel, texel, place, t, visibleDepth(visible));
}

// Returns the number of triangles visible in a pixel besides the first; `samples` returns the samples of the first.
uint moreTriangles(uint first, out uint samples) {
  VisibleRef visible = VisibleRef(push.visible);
  uint left = coveredSamples(visible, first), more = 0u;
  samples = nextTriangle(visible, first, left);
  for (; left != 0u; ++more) nextTriangle(visible, first, left);
  return more;
}

uint samplesOfTriangle(uint first, uint number) {
  VisibleRef visible = VisibleRef(push.visible);
  uint left = coveredSamples(visible, first), samples = 0u;
  for (uint i = 0u; i <= number; ++i) samples = nextTriangle(visible, first, left);
  return samples;
}

// Each invocation resolves its pixel's first triangle; the remaining triangles are redistributed to the lanes of the
// subgroup. With one sample per pixel there is at most one triangle.
void main() {
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  ivec3 pixel = ownPixel();
  View view = frameView(frame, uint(pixel.z));
  ivec2 size = ivec2(view.size);
  bool inside = all(lessThan(pixel.xy, size));
  if (kSamples == 1u && !inside) return;
  uint samples = 1u;
  if (kSamples > 1u) {
    samples = 0u;
    uint more = inside ? moreTriangles(visibleIndex(uvec3(pixel), uvec2(size)), samples) : 0u;
    redistribute(more, pixel.xy);
  }
  for (uint round = 0u;; ++round) {
    if (samples != 0u) resolve(frame, view, pixel, samples);
    if (kSamples == 1u) break;  // no loop: faster on lavapipe
    if (round == itemRounds()) break;
    LaneItem next = laneItem(round);
    pixel.xy = next.pixel;
    samples = next.there ? samplesOfTriangle(visibleIndex(uvec3(pixel), uvec2(size)), next.index + 1u) : 0u;
  }
}
