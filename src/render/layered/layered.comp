#version 460
#extension GL_GOOGLE_include_directive : require
// variants: textured
// Forward shading of layered materials (surfaces with coats) from the visibility buffer, in the pixels that show some.
// With several samples per pixel, each triangle is shaded once. Lights come from the technique's light lists, or from
// the light tree if there are none. Inputs: push.shown (visibility buffer), push.lists. Output: the surfaces' light in
// lightTarget, and lightCounts.
#define COATED
#include "render/glsl/common.glsl"
#include "render/visibility/compute/surface_point.glsl"
#include "render/layered/layered_light.glsl"
#include "render/visibility/compute/visible.glsl"
#include "render/visibility/compute/pixel_triangles.glsl"
#include "render/glsl/pixel_group.glsl"
#include "render/glsl/shade_cells.glsl"
#include "render/glsl/surface_fog.glsl"
#include "render/layered/layered_push.h"

layout(push_constant, scalar) uniform Push { LayeredPush push; };
layout(set = 0, binding = AFTER_LIT_MAPS, rgba16f) uniform image2DArray lightTarget;
layout(set = 0, binding = AFTER_LIT_MAPS + 1, rgba32f) uniform writeonly image2DArray lightCounts;

bool isLayered(FrameConstants frame, uint id) {
  InstanceList list = InstanceListRef(push.shown.instances).v;
  uint drawIndex = DrawIndexOfPartRef(list.drawIndexOfPart).v[(id - 1u) / kRasterGroup];
  return (rasterInstanceAt(list, frame, drawIndex).flags & kDrawLayered) != 0u;
}

// Returns the mask of samples of the next triangle with a layered material, or 0 if none is left. Removes them and the
// preceding samples from `left`.
uint nextLayered(FrameConstants frame, uint first, inout uint left) {
  VisibleRef visible = VisibleRef(push.shown.visible);
  uint found = 0u;
  while (left != 0u && found == 0u) {
    uint samples = nextTriangle(visible, first, left);
    if (isLayered(frame, visibleId(visible.v[first + uint(findLSB(samples))]))) found = samples;
  }
  return found;
}

// The radiance from all lights. With several samples per pixel there are no lists, because those of the lighting
// technique are built for other surfaces.
vec3 lightsOn(FrameConstants frame, View view, uint viewIndex, uint64_t visible, LayeredPoint point, LayeredBrdf brdf,
              bool shows) {
  if (kCellsPerTile == 0u) return lightsAtPoint(frame, viewIndex, point, brdf, shows, false);
  CellLookup place = CellLookup(gl_WorkGroupID, view.projection, visibleDepth(visible));
  return shadeFromCells(frame, push.lists, place, point.s, brdf, shows);
}

// The radiance of the surface that these samples of a pixel show. Every invocation of the subgroup must call it.
// Invocations without samples evaluate an arbitrary triangle, and their result is discarded.
vec3 radianceOf(FrameConstants frame, ivec3 pixel, uint first, uint samples) {
  View view = frameView(frame, uint(pixel.z));
  uint64_t visible = samples != 0u ? VisibleRef(push.shown.visible).v[first + uint(findLSB(samples))] : uint64_t(1);
  VisibleTriangle t = visibleTriangle(frame, push.shown.instances, visibleId(visible));
  SurfacePoint p = visiblePoint(frame, view, t, vec2(pixel.xy) + sampleCentroid(samples));
  Material m = frameMaterial(frame, frameInstance(frame, t.draw.instance).material);
  LayeredPoint point = layeredPoint(frame, uint(pixel.z), m, p);
  point.s.ao *= visibleHemisphere(pixel);
  LayeredBrdf brdf = layeredBrdfAt(point);
  vec3 radiance = layeredEnvironment(frame, brdf, point.toEye);
  radiance += layeredAreaLight(frame, brdf);
  radiance += lightsOn(frame, view, uint(pixel.z), visible, point, brdf, samples != 0u);
  vec3 sent = exposedRadiance(frame, point, brdf, radiance);
  return kSamples == 1u ? sent : sent * transmittanceFrom(frame, view, point.s.position);
}

void main() {
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
#ifndef TEXTURES_BY_INDEX
  textureRecords = frame.textures;
#endif
  ivec3 pixel = ownPixel();
  uvec2 size = uvec2(frameView(frame, uint(pixel.z)).size);
  bool inside = all(lessThan(uvec2(pixel.xy), size));
  uint first = visibleIndex(uvec3(inside ? uvec2(pixel.xy) : uvec2(0u), pixel.z), size);
  uint left = inside ? coveredSamples(VisibleRef(push.shown.visible), first) : 0u, covered = 0u;
  uint samples = nextLayered(frame, first, left);
  if (!subgroupAny(samples != 0u)) return;
  vec3 sum = vec3(0.0);
  while (true) {
    vec3 one = radianceOf(frame, pixel, first, samples);
    if (samples != 0u) sum += one * (float(bitCount(samples)) / float(kSamples));
    covered |= samples;
    if (kSamples == 1u) break;  // removes the loop, which lavapipe would execute once more with nothing to light
    samples = nextLayered(frame, first, left);
    if (!subgroupAny(samples != 0u)) break;
  }
  if (covered == 0u) return;
  if (kCountLights != 0u) imageStore(lightCounts, pixel, lightCount());
  vec4 light = vec4(0.0, 0.0, 0.0, 1.0);  // radiance of the pixel's other surfaces, and of fog
  bool hasFog = kSamples > 1u && frame.fog.density > 0.0;
  if (uint(bitCount(covered)) != kSamples || hasFog) light = imageLoad(lightTarget, pixel);
  imageStore(lightTarget, pixel, vec4(min(light.rgb + sum, vec3(65504.0)), light.a));
}
