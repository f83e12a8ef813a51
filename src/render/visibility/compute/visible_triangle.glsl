// The visible triangle of a pixel, from its id in the visibility buffer, and the barycentric coordinates of the ray
// through the pixel's center (Moeller and Trumbore 1997, Fast, Minimum Storage Ray/Triangle Intersection, JGT 2(1)).
// Their derivatives are exact, so texture sampling needs no neighboring pixels.
#ifndef LATELIGHT_SEEN_TRIANGLE_GLSL
#define LATELIGHT_SEEN_TRIANGLE_GLSL
#include "render/glsl/pixel_ray.glsl"
#include "render/visibility/compute/raster_push.h"
#include "load/RasterInstance.glsl"
#include "render/visibility/vast_triangle.glsl"

layout(constant_id = kVastConstant) const uint kVast = 0u;  // FrameConfig::vast

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DrawIndexOfPartRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer InstanceListRef { InstanceList v; };

// `frame`: the constants of the view, whose world may have its own instances.
RasterInstance rasterInstanceAt(InstanceList list, FrameConstants frame, uint drawIndex) {
  uint64_t records = kWorlds != 0u ? frame.rasterInstances : list.rasterInstances;
  return loadRasterInstance(records + uint64_t(drawIndex) * kRasterInstanceBytes);
}

// --- triangle --------------------------------------------------------------------------------------------------------

struct VisibleTriangle {
  RasterInstance draw;
  uint number;  // index in its mesh
  uvec3 indices;
};

VisibleTriangle visibleTriangle(FrameConstants frame, uint64_t instances, uint id) {
  InstanceList list = InstanceListRef(instances).v;
  VisibleTriangle t;
  t.draw = rasterInstanceAt(list, frame, DrawIndexOfPartRef(list.drawIndexOfPart).v[(id - 1u) / kRasterGroup]);
  t.number = id - 1u - t.draw.firstTriangle;
  t.indices = triangleIndices(frameMesh(frame, t.draw.mesh), t.number);
  return t;
}

// The same for a texel of the image of addTriangles() (visibility.h). The scene has no vast triangles.
VisibleTriangle drawnTriangle(FrameConstants frame, uvec2 drawn) {
  VisibleTriangle t;
  t.draw.instance = drawn.x - 1u;
  t.draw.mesh = frameInstance(frame, t.draw.instance).mesh;
  t.draw.stretch = 1.0;
  t.draw.flags = 0u;
  t.number = drawn.y;
  t.indices = triangleIndices(frameMesh(frame, t.draw.mesh), t.number);
  return t;
}

// Returns the corners in view space.
vec3[3] cornersOf(FrameConstants frame, View view, VisibleTriangle t) {
  mat4x3 placed = relativeToEye(frameInstance(frame, t.draw.instance), view);
  uint64_t positions = frameMesh(frame, t.draw.mesh).positions;
  vec3 corners[3];
  for (int i = 0; i < 3; ++i)
    corners[i] = toView(view, placed * vec4(positionAt(positions, t.indices[i]), 1.0));
  return corners;
}

// Returns the corners of a vast triangle in view space.
Exact3[3] vastCornersOf(FrameConstants frame, View view, VisibleTriangle t) {
  Instance instance = frameInstance(frame, t.draw.instance);
  uint64_t positions = frameMesh(frame, t.draw.mesh).positions;
  Exact3 corners[3];
  for (int i = 0; i < 3; ++i) corners[i] = seenExactly(view, instance, positionAt(positions, t.indices[i]));
  return corners;
}

// Returns the intersection of a pixel's ray with the plane of a vast triangle, in view space.
vec3 vastPoint(FrameConstants frame, View view, Exact3 corners[3], vec2 pixel) {
  ViewPlane plane = planeOf(corners[0], corners[1], corners[2]);
  vec3 ray = pixelRay(frame, view, pixel), from = vec3(0.0);
  if (view.projection.kind != kPerspective)
    from = viewPositionAtDepth(view.projection, pixelToNdc(pixel, view.size), 0.0);
  return from + ray * ((plane.distance - dot(plane.normal, from)) / dot(plane.normal, ray));
}

bool isVast(VisibleTriangle t) { return kVast != 0u && (t.draw.flags & kDrawVast) != 0u; }

// --- barycentric coordinates -----------------------------------------------------------------------------------------

struct Weights {  // barycentric coordinates, and their derivatives per pixel to the right and down
  vec3 at, right, down;
};

// Corners are in view space.
Weights weightsAt(FrameConstants frame, View view, vec3 a, vec3 b, vec3 c, vec2 pixel) {
  vec2 ndc = pixelToNdc(pixel, view.size);
  vec2 step = vec2(2.0, -2.0) / view.size;
  vec3 toB = b - a, toC = c - a;
  vec3 ray = pixelRay(frame, view, pixel);
  // The derivatives of the ray's direction, or, for orthographic projections, of its origin.
  vec3 rightward = vec3(step.x / view.projection.H, 0.0, 0.0), downward = vec3(0.0, 0.0, step.y / view.projection.V);
  if (kLens != 0u) {
    rightward = lensStep(frame, view, ivec2(pixel), ivec2(1, 0));
    downward = lensStep(frame, view, ivec2(pixel), ivec2(0, 1));
  }
  vec2 uv, uvRight, uvDown;
  if (view.projection.kind == kPerspective) {
    vec3 t = -a, normal = cross(toC, toB);
    float scale = 1.0 / dot(ray, normal);
    vec3 forB = cross(toC, t), forC = cross(t, toB);
    uv = vec2(dot(ray, forB), dot(ray, forC)) * scale;
    uvRight = (vec2(dot(rightward, forB), dot(rightward, forC)) - uv * dot(rightward, normal)) * scale;
    uvDown = (vec2(dot(downward, forB), dot(downward, forC)) - uv * dot(downward, normal)) * scale;
  } else {
    vec3 t = viewPositionAtDepth(view.projection, ndc, 0.0) - a;
    vec3 forB = cross(ray, toC), forC = cross(toB, ray);
    float sideways = 1.0 / dot(toB, forB);
    uv = vec2(dot(t, forB), dot(t, forC)) * sideways;
    uvRight = vec2(dot(rightward, forB), dot(rightward, forC)) * sideways;
    uvDown = vec2(dot(downward, forB), dot(downward, forC)) * sideways;
  }
  // Snapping lets a triangle cover pixels slightly outside of it. The rays of pixels on an edge-on triangle may meet
  // its plane anywhere.
  uv = clamp(uv, vec2(-1.0), vec2(2.0));
  return Weights(vec3(1.0 - uv.x - uv.y, uv), vec3(-uvRight.x - uvRight.y, uvRight),
                 vec3(-uvDown.x - uvDown.y, uvDown));
}

#endif
