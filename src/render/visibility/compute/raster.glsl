// Watertight rasterization: vertices are snapped to 1/256 pixel by one function, edges are exact in integers, and a
// pixel's centre on an edge belongs to the triangle whose top or left edge it is, as the graphics pipeline has it
// (Vulkan 1.3, section 28.12.1; Fatahalian and others 2009, Data-Parallel Rasterization of Micropolygons).
#ifndef LATELIGHT_RASTER_GLSL
#define LATELIGHT_RASTER_GLSL
#extension GL_EXT_shader_atomic_int64 : require
#include "render/glsl/common.glsl"
#include "render/visibility/compute/seen_triangle.glsl"

layout(push_constant, scalar) uniform Push { RasterPush push; };

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer VisibleRef { uint64_t v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer WorkRef { RasterWork v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ClippedRef { ClippedTriangle v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer LargeRef { LargeTriangle v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer TilesRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer EntriesRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer JobsRef { RasterJob v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CountersRef { RasterCounters v; };

// --- vertices -------------------------------------------------------------------------------------------------------

vec4 clipPosition(View view, mat4x3 toWorld, vec3 position) {
  precise vec3 world = toWorld * vec4(position, 1.0);
  precise vec3 seen = view.worldToView * vec4(world, 1.0);
  precise vec4 clip = projectToClip(view.projection, seen);
  return clip;
}

// Within these many half pictures of the middle, positions in subpixels fit into 31 bits, and products of their
// differences into 63.
const float kGuardBand = 128.0;

// Distances from the planes of the view's volume, positive inside: near, far, and the guard band's sides.
float planeDistance(vec4 clip, uint plane) {
  switch (plane) {
    case 0u: return clip.w - clip.z;
    case 1u: return clip.z;
    case 2u: return kGuardBand * clip.w - clip.x;
    case 3u: return kGuardBand * clip.w + clip.x;
    case 4u: return kGuardBand * clip.w - clip.y;
    default: return kGuardBand * clip.w + clip.y;
  }
}

// Bit i: outside of plane i. A vertex without a number is outside of all.
uint planesOutside(vec4 clip) {
  uint outside = 0u;
  for (uint plane = 0u; plane < 6u; ++plane) outside |= planeDistance(clip, plane) >= 0.0 ? 0u : 1u << plane;
  return outside;
}

// Bit i: outside of a side of the picture itself.
uint sidesOutside(vec4 clip) {
  return (clip.x > clip.w ? 1u : 0u) | (clip.x < -clip.w ? 2u : 0u) | (clip.y > clip.w ? 4u : 0u) |
         (clip.y < -clip.w ? 8u : 0u);
}

struct ScreenVertex {
  ivec2 at;     // subpixels from the upper left
  float depth;  // of the device
};

ScreenVertex screenVertex(vec4 clip) {
  precise float scale = 1.0 / clip.w;
  precise float x = (clip.x * scale * 0.5 + 0.5) * (float(push.width) * float(kSubpixels));
  precise float y = (0.5 - clip.y * scale * 0.5) * (float(push.height) * float(kSubpixels));
  precise float depth = clip.z * scale;
  return ScreenVertex(ivec2(floor(vec2(x, y) + 0.5)), clamp(depth, 0.0, 1.0));
}

// --- triangles ------------------------------------------------------------------------------------------------------

// Clockwise as seen (y is down), so that what is inside has three positive weights.
struct Triangle {
  ivec2 a, b, c;
  vec3 depth;
  uint id;
};

// The pixels whose centres may be inside: both included; none where a corner of `low` is beyond that of `high`.
struct PixelBox {
  ivec2 low, high;
};
PixelBox pixelsOf(Triangle t) {
  ivec2 low = min(t.a, min(t.b, t.c)), high = max(t.a, max(t.b, t.c));
  const int kHalf = kSubpixels / 2;
  return PixelBox((low + kHalf - 1) >> 8, (high - kHalf) >> 8);
}
PixelBox onScreen(PixelBox box) {
  return PixelBox(max(box.low, ivec2(0)), min(box.high, ivec2(push.width, push.height) - 1));
}
bool isEmpty(PixelBox box) { return any(greaterThan(box.low, box.high)); }

// Whether the centre of a pixel on this edge, going that way around the triangle, belongs to it: top and left edges.
bool ownsEdge(ivec2 way) { return way.y < 0 || (way.y == 0 && way.x > 0); }

// The id is the larger the later it is drawn: of equal depths the last one shows.
void writeVisible(uint view, ivec2 pixel, float depth, uint id) {
  VisibleRef visible = VisibleRef(push.buffers.visible);
  uint index = (view * push.height + uint(pixel.y)) * push.width + uint(pixel.x);
  uint64_t value = uint64_t(floatBitsToUint(depth)) << 32 | uint64_t(id);
  if (visible.v[index] < value) atomicMax(visible.v[index], value);
}

// Weights of the corners are exact; what they sum up has the relative error of a few roundings, however far away.
float depthAt(vec3 depth, float a, float b, float c, float scale) {
  precise float sum = depth.x * a + depth.y * b + depth.z * c;
  precise float scaled = sum * scale;
  return scaled;
}

// Turns the triangle so that it is clockwise; false where it is to be left out: seen from its back, or without an area.
bool orient(inout Triangle t, bool doubleSided, bool mirrored) {
  int64_t area = int64_t(t.b.x - t.a.x) * int64_t(t.c.y - t.a.y) - int64_t(t.b.y - t.a.y) * int64_t(t.c.x - t.a.x);
  if (area == 0) return false;
  // Front faces are counter-clockwise as seen, unless the instance is mirrored.
  bool front = (area < 0) != mirrored;
  if (!front && !doubleSided) return false;
  if (area < 0) {
    ivec2 b = t.b;
    t.b = t.c;
    t.c = b;
    t.depth = t.depth.xzy;
  }
  return true;
}

void pushLarge(uint view, Triangle t) {
  uint place = atomicAdd(CountersRef(push.buffers.counters).v.large, 1u);
  if (place < push.largeRoom)
    LargeRef(push.buffers.large).v[place] = LargeTriangle(t.a.x, t.a.y, t.b.x, t.b.y, t.c.x, t.c.y, t.depth.x, t.depth.y,
                                                          t.depth.z, t.id, view);
}

uvec3 triangleIndices(Mesh mesh, uint triangle) {
  UintRef indices = UintRef(mesh.indices);
  return uvec3(indices.v[3u * triangle], indices.v[3u * triangle + 1u], indices.v[3u * triangle + 2u]);
}

// The workgroup's number in an indirect dispatch (raster_arguments.comp).
uint groupNumber() { return gl_WorkGroupID.y * kRasterRow + gl_WorkGroupID.x; }

#endif
