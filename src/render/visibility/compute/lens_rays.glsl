// Images through a lens: intersects the lens rays that lie in a pixel of a pinhole view with a triangle that touches
// the pixel. Include after raster.glsl and surface_point.glsl.
#include "render/lens/lens_push.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer LensTargetRef { LensTarget v; };
layout(constant_id = kAlphaTestConstant) const uint kAlphaTest = 0u;  // 1: triangles are alpha tested

// Two unit vectors across a ray, which form a right-handed frame with it.
struct Across {
  vec3 right, up;
};
Across across(vec3 ray) {
  vec3 other = abs(ray.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
  precise vec3 right = normalize(cross(other, ray));
  precise vec3 up = cross(ray, right);
  return Across(right, up);
}

float crossed(vec2 a, vec2 b) {
  precise float area = a.x * b.y - a.y * b.x;
  return area;
}

// Returns the distance in meters along a ray to a triangle with corners in view space, or 0 if the ray misses it. The
// corners' projections across the ray are the same for all triangles that share them, so the areas of a shared edge
// differ only in sign and no ray passes between two triangles (Woop, Benthin and Wald 2013, Watertight Ray/Triangle
// Intersection, JCGT 2(1)).
float meet(vec3 corners[3], vec3 ray, uint flags) {
  Across beside = across(ray);
  vec2 at[3];
  vec3 along;
  for (int i = 0; i < 3; ++i) {
    precise vec2 place = vec2(dot(beside.right, corners[i]), dot(beside.up, corners[i]));
    at[i] = place;
    along[i] = dot(ray, corners[i]);
  }
  vec3 areas = vec3(crossed(at[1], at[2]), crossed(at[2], at[0]), crossed(at[0], at[1]));
  bool inside = all(greaterThanEqual(areas, vec3(0.0))) || all(lessThanEqual(areas, vec3(0.0)));
  float area = areas.x + areas.y + areas.z;
  // Front faces are counter-clockwise on screen, unless the instance is mirrored (kDrawClockwise).
  bool front = (area < 0.0) != ((flags & kDrawClockwise) != 0u);
  if (!inside || area == 0.0 || !(front || (flags & kDrawDoubleSided) != 0u)) return 0.0;
  float distance = dot(areas, along) / area;
  return distance > 0.0 && distance < 3.0e38 ? distance : 0.0;
}

// Called for each hit of a lens ray; the including shader defines it. `view` is the lens image's view; `depth` is
// device depth.
void meets(FrameConstants frame, uint view, ivec2 pixel, float depth, uint id);

bool failsAlphaTest(FrameConstants frame, View view, VisibleTriangle t, ivec2 pixel) {
  if (kAlphaTest == 0u) return false;
#ifndef TEXTURES_BY_INDEX
  textureRecords = frame.textures;
#endif
  SurfacePoint p = visiblePoint(frame, view, t, vec2(pixel) + 0.5);
  return masked(frameMaterial(frame, frameInstance(frame, t.draw.instance).material), p);
}

void hit(uint view, ivec2 pixel, uint samples, PixelDepth depth, uint id) {
  LensTarget target = LensTargetRef(push.within).v;
  uint place = pixelIndex(uvec3(pixel, view % target.views), uvec2(push.width, push.height));
  uint next = UintRef(target.starts).v[place], end = UintRef(target.starts).v[place + 1u];
  if (next == end) return;
  FrameConstants frame = frameOf(target.frame, view / target.views);
  View camera = frameView(frame, view / target.views);
  VisibleTriangle t = visibleTriangle(frame, push.buffers.instances, id);
  vec3 corners[3] = cornersOf(frame, camera, t);
  do {  // tested at the end, because lavapipe would execute the body once more
    uint ray = UintRef(target.pixels).v[next];
    ivec2 at = ivec2(ray % target.width, ray / target.width);
    float distance = meet(corners, lensRay(frame, camera, at).direction, t.draw.flags);
    if (distance != 0.0 && isVast(t))
      distance = length(vastPoint(frame, camera, vastCornersOf(frame, camera, t), vec2(at) + 0.5));
    if (distance != 0.0 && !failsAlphaTest(frame, camera, t, at))
      meets(frame, view / target.views, at, deviceDepth(camera.projection, distance), id);
  } while (++next < end);
}
