// Watertight software rasterization, the common part of all raster_*.comp. Vertices are snapped to 1/256 pixel by one
// function, edge functions are exact integers, and the top-left rule decides which triangle owns a sample on an edge,
// as in the graphics pipeline (Vulkan 1.3, section 28.12.1; Fatahalian et al. 2009, Data-Parallel Rasterization of
// Micropolygons). The S samples of a pixel lie in a grid of S columns and S rows (shared/samples.h); edge functions are
// set up at the first position of that grid.
#ifndef LATELIGHT_RASTER_GLSL
#define LATELIGHT_RASTER_GLSL
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_KHR_shader_subgroup_basic : require
#include "render/glsl/common.glsl"
#include "render/visibility/compute/drawn_pages.glsl"
#include "render/visibility/compute/visible_triangle.glsl"
#include "render/visibility/compute/visible.glsl"
#include "render/visibility/triangle_depth.glsl"

layout(push_constant, scalar) uniform Push { RasterPush push; };

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer WorkRef { RasterWork v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ClippedRef { ClippedTriangle v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer LargeRef { LargeTriangle v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TilesRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer EntriesRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer JobsRef { RasterJob v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CountersRef { RasterCounters v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ClusterRef { Cluster v[]; };

// --- vertices --------------------------------------------------------------------------------------------------------

// The guard band, in half image sizes from the center; triangles that reach beyond it are clipped. It is 16,384 pixels,
// so that the edge functions of a tile fit into 32 bits (raster_large.comp); no image is wider.
vec2 guardBand() { return max(32768.0 / vec2(push.width, push.height), vec2(1.0)); }

// Returns the signed distance from a plane of the view volume, positive inside. The planes are near, far, and the four
// sides of the guard band.
float planeDistance(vec4 clip, uint plane) {
  switch (plane) {
    case 0u: return clip.w - clip.z;
    case 1u: return clip.z;
    case 2u: return guardBand().x * clip.w - clip.x;
    case 3u: return guardBand().x * clip.w + clip.x;
    case 4u: return guardBand().y * clip.w - clip.y;
    default: return guardBand().y * clip.w + clip.y;
  }
}

// Returns a bit for each side of the image, and for the near and far plane, that the vertex is outside of, and
// kOutsideVolume. A vertex with a NaN is outside the volume and outside the near and far planes.
const uint kOutsideVolume = 64u;
uint outsideOf(vec4 clip) {
  vec2 guard = guardBand() * clip.w;
  bool near = clip.w - clip.z >= 0.0, far = clip.z >= 0.0;
  bool inside = near && far && abs(clip.x) <= guard.x && abs(clip.y) <= guard.y;
  return (clip.x > clip.w ? 1u : 0u) | (clip.x < -clip.w ? 2u : 0u) | (clip.y > clip.w ? 4u : 0u) |
         (clip.y < -clip.w ? 8u : 0u) | (near ? 0u : 16u) | (far ? 0u : 32u) | (inside ? 0u : kOutsideVolume);
}

// Returns subpixels from the upper left corner.
ivec2 screenPosition(vec4 clip) {
  precise float scale = 1.0 / clip.w;
  precise float x = (clip.x * scale * 0.5 + 0.5) * (float(push.width) * float(kSubpixels));
  precise float y = (0.5 - clip.y * scale * 0.5) * (float(push.height) * float(kSubpixels));
  return ivec2(floor(vec2(x, y) + 0.5));
}

struct Corner {  // of a triangle
  vec3 seen;     // view space
  ivec2 screen;  // in subpixels
  float depth;   // device depth
  uint outside;
};
Corner cornerAt(View view, mat4x3 placed, vec3 position) {
  Corner corner;
  corner.seen = seenPosition(view, placed, position);
  vec4 clip = clipPosition(view, corner.seen);
  corner.screen = screenPosition(clip);
  corner.depth = deviceDepthOf(clip);
  corner.outside = outsideOf(clip);
  return corner;
}

// --- triangles -------------------------------------------------------------------------------------------------------

// Clockwise on screen (y is down), so that the three edge functions are positive inside.
struct Triangle {
  ivec2 a, b, c;
  vec3 plane;  // as in LargeTriangle
  float least, most;
  uint id;
};

float depthAt(View view, Triangle t, ivec2 pixel) { return depthOn(t.plane, rayAt(view, vec2(pixel) + 0.5)); }

void setRange(inout Triangle t, View view, float least, float most) {
  vec2 range = depthRange(view, t.plane, least, most);
  t.least = range.x;
  t.most = range.y;
}

// --- samples ---------------------------------------------------------------------------------------------------------

const int kSubpixelStep = kSubpixels / int(kSamples);  // between columns or rows of samples, in subpixels
const int kFirstSampleOffset = kSubpixelStep / 2;   // offset of the first one

// 1: conservative rasterization. A triangle covers every pixel that it touches, regardless of its facing; hit() decides
// the rest.
layout(constant_id = kTouchedConstant) const uint kTouched = 0u;
// Distance in subpixels that edges are moved outwards: half a pixel, and a margin for snapping.
const int kReach = kTouched != 0u ? kSubpixels / 2 + 2 : 0;
int reachOf(ivec2 way) { return kTouched != 0u ? (abs(way.x) + abs(way.y)) * kReach + 1 : 0; }

// Returns the covered samples of a pixel. `at` are the three edge functions at the first sample position, where 0 is
// inside; `right` and `down` are their steps between sample positions.
uint coveredSamples(ivec3 at, ivec3 right, ivec3 down) {
  if (kSamples == 1u) return (at.x | at.y | at.z) >= 0 ? 1u : 0u;
  uint covered = 0u;
  for (uint i = 0u; i < kSamples; ++i) {
    ivec3 w = at + right * int(sampleColumn(kSamples, i)) + down * int(sampleRow(kSamples, i));
    covered |= (w.x | w.y | w.z) >= 0 ? 1u << i : 0u;
  }
  return covered;
}

// The depths of a triangle within one pixel.
struct PixelDepth {
  float center;
  vec2 steps;
  float least, most;
};
float depthAt(PixelDepth d, vec2 place) {
  return withinRange(d.least, d.most, d.center + dot(d.steps, place - 0.5));
}
float depthAt(PixelDepth d, uint index) {
  return kSamples == 1u ? withinRange(d.least, d.most, d.center) : depthAt(d, samplePlace(kSamples, index));
}

// --- boxes -----------------------------------------------------------------------------------------------------------

// Returns the pixels with samples that may be inside.
PixelBox pixelsOf(Triangle t) {
  ivec2 low = min(t.a, min(t.b, t.c)), high = max(t.a, max(t.b, t.c));
  return PixelBox((low + kFirstSampleOffset - 1 - kReach) >> 8, (high - kFirstSampleOffset + kReach) >> 8);
}
PixelBox onScreen(PixelBox box) {
  return PixelBox(max(box.low, ivec2(0)), min(box.high, ivec2(push.width, push.height) - 1));
}

bool isDrawn(uint view, PixelBox box) { return isDrawn(push.within, push.fragments, view, box); }

const int kSmallBox = kSamples <= 4u ? 32 / int(kSamples) : 9;  // in pixels: bits of pixelsInside()
const int kMediumBox = (kCpuDevice != 0u ? kMediumPixelsOfCpu : kMediumPixels) / (kSamples <= 4u ? int(kSamples) : 4);
// Maximum extent in pixels for which edge functions fit into 32 bits at all samples, including the blocks that begin
// within the extent. Blocks reach 8 pixels farther, and samples less than one pixel more: 2 * 119 * 128 * 256^2 < 2^31.
const int kLargestSide = 119;

// Returns the size class kRaster* of an unclipped triangle; `box` are its pixels on screen.
uint sizeClass(Triangle t, PixelBox box) {
  ivec2 corners = max(t.a, max(t.b, t.c)) - min(t.a, min(t.b, t.c));
  ivec2 size = box.high - box.low + 1;
  if (max(corners.x, corners.y) > kLargestSide * kSubpixels || size.x * size.y > kMediumBox) return kRasterLarge;
  return size.x * size.y > kSmallBox ? kRasterMedium : kRasterSmall;
}

// Top-left rule: returns true if samples on an edge in this direction around the triangle belong to it.
bool ownsEdge(ivec2 way) { return way.y < 0 || (way.y == 0 && way.x > 0); }

void writeVisible(uint index, uint64_t value) {
  VisibleRef visible = VisibleRef(push.buffers.visible);
  // On lavapipe a load is a loop over lanes, as the atomic maximum itself is, so testing first saves nothing.
  if (kCpuDevice != 0u || visible.v[index] < value) atomicMax(visible.v[index], value);
}
uint visibleAt(uint view, ivec2 pixel) { return visibleIndex(uvec3(pixel, view), uvec2(push.width, push.height)); }

void writeSamples(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  uint first = visibleAt(view, pixel);
  for (uint i = 0u; i < kSamples; ++i)
    if (hasSample(samples, i)) writeVisible(first + i, visibleValue(depthAt(depth, i), id));
}

// Makes the triangle clockwise. Returns false if it is culled, because it is a back face or has no area.
bool orient(inout Triangle t, RasterInstance r) {
  bool doubleSided = (r.flags & kDrawDoubleSided) != 0u || kShadowMaps != 0u;
  bool clockwise = (r.flags & kDrawClockwise) != 0u;
  int64_t area = int64_t(t.b.x - t.a.x) * int64_t(t.c.y - t.a.y) - int64_t(t.b.y - t.a.y) * int64_t(t.c.x - t.a.x);
  if (area == 0 && kTouched == 0u) return false;
  // Front faces are counter-clockwise on screen, unless the instance is mirrored (kDrawClockwise).
  bool front = (area < 0) != clockwise;
  if (!front && !doubleSided && kTouched == 0u) return false;
  if (area < 0) {
    ivec2 b = t.b;
    t.b = t.c;
    t.c = b;
  }
  return true;
}

LargeTriangle queued(uint view, Triangle t) {
  return LargeTriangle(t.a.x, t.a.y, t.b.x, t.b.y, t.c.x, t.c.y, t.plane, t.least, t.most, t.id, view);
}
Triangle triangleOf(LargeTriangle t) {
  return Triangle(ivec2(t.ax, t.ay), ivec2(t.bx, t.by), ivec2(t.cx, t.cy), t.plane, t.least, t.most, t.id);
}
void pushLarge(uint view, Triangle t) {
  uint place = atomicAdd(CountersRef(push.buffers.counters).v.large, 1u);
  if (place < push.largeCapacity) LargeRef(push.buffers.large).v[place] = queued(view, t);
}

#endif
