// Ground-truth ambient occlusion (GTAO; Jimenez, Wu, Pesce and Jarabo 2016, Practical Realtime Strategies for Accurate
// Indirect Occlusion, Activision) of one pixel from the depth around it. Include after common.glsl and `gbufferDepth`.
// The including shader provides the normal; occlusionAt() returns the occluded fraction of the cosine-weighted
// hemisphere (formulas: shared/ambient_occlusion.h). The hemisphere is divided into slices, which are planes through
// the direction to the eye, and each half of a slice is sampled outward for its horizon.
//
// Nothing is random: the 16 pixels of a 4x4 block use different slice directions, spread evenly over the block, and
// ambient_occlusion_denoise.comp averages blocks.
#include "render/glsl/lens_calibration.glsl"
#include "render/glsl/pixel_ray.glsl"
#include "render/post/ambient_occlusion/ambient_occlusion_push.h"
#include "shared/ambient_occlusion.h"

layout(constant_id = kSlicesConstant) const uint kSlicesPerPixel = 3;
layout(constant_id = kStepsConstant) const uint kStepsPerSide = 6;
layout(push_constant, scalar) uniform Push { OcclusionPush push; };

// A pixel and the plane of its surface in screen space.
struct Center {
  ivec3 place;
  vec2 pixel;  // its center
  float depth;
  // Change of device depth per pixel along each axis, toward the neighbor that is nearer in depth, which lies on the
  // same surface.
  vec2 slope;
  vec3 position;  // view space
  vec3 toEye;
  // With a lens, `depth` and `slope` are not used. On the surface's plane, dot(plane, unit ray) is 1 / distance.
  vec3 plane;
  vec3 right, down;  // unit vectors across the ray
  float pixelAngle;  // size of the pixel at 1 m from the eye
};

float depthAt(ivec3 place, ivec2 size) {
  return texelFetch(gbufferDepth, ivec3(clamp(place.xy, ivec2(0), size - 1), place.z), 0).r;
}

float smallerStep(float before, float here, float after) {
  float a = here - before, b = after - here;
  return abs(a) < abs(b) ? a : b;
}

vec2 slopeAt(ivec3 place, ivec2 size, float depth) {
  // At the edge of the picture, clamping would repeat the pixel in place of the missing neighbor, and the slope would
  // be 0. The missing neighbor is therefore ignored.
  float left = place.x > 0 ? depthAt(place - ivec3(1, 0, 0), size) : 3.0e38;
  float right = place.x + 1 < size.x ? depthAt(place + ivec3(1, 0, 0), size) : 3.0e38;
  float above = place.y > 0 ? depthAt(place - ivec3(0, 1, 0), size) : 3.0e38;
  float below = place.y + 1 < size.y ? depthAt(place + ivec3(0, 1, 0), size) : 3.0e38;
  vec2 slope = vec2(smallerStep(left, depth, right), smallerStep(above, depth, below));
  return mix(slope, vec2(0.0), greaterThan(abs(slope), vec2(1.0e38)));
}

#include "render/post/ambient_occlusion/gtao_lens.glsl"

Center centerAt(View view, ivec3 place, float depth) {
  Center c;
  if (kLens != 0u) return lensCenterAt(view, place, depth);
  c.place = place;
  c.pixel = vec2(place.xy) + 0.5;
  c.depth = depth;
  c.slope = slopeAt(place, ivec2(view.size), depth);
  vec2 ndc = pixelToNdc(c.pixel, view.size);
  c.position = viewPositionAtDepth(view.projection, ndc, viewDepth(view.projection, depth));
  c.toEye = view.projection.kind == kPerspective ? normalize(-c.position) : vec3(0.0, -1.0, 0.0);
  return c;
}

vec3 normalFromDepth(View view, Center c) {
  // A pixel is 2 / width wide in NDC, and y points up in NDC.
  vec2 gradient = c.slope * 0.5 * view.size * vec2(1.0, -1.0);
  return normalFromDepth(view.projection, pixelToNdc(c.pixel, view.size), c.depth, gradient);
}

// Finds the view-space position of the surface `offset` pixels away. Returns false if there is none.
bool sampleAt(View view, Center c, vec2 offset, out vec3 position) {
  position = vec3(0.0);
  if (kLens != 0u) return lensSampleAt(view, c, offset, position);
  vec2 exact = c.pixel + offset;
  ivec2 texel = ivec2(floor(exact));
  bool inside = all(greaterThanEqual(exact, vec2(0.0))) && all(lessThan(exact, view.size));
  float depth = inside ? texelFetch(gbufferDepth, ivec3(texel, c.place.z), 0).r : 0.0;
  if (depth == 0.0) return false;
  // The slice does not pass through the texel's center. The sample is moved into the slice along the pixel's own plane,
  // so the samples of a planar surface lie exactly in its plane at any angle, and flat surfaces do not occlude
  // themselves.
  depth += dot(c.slope, exact - (vec2(texel) + 0.5));
  position = viewPositionAtDepth(view.projection, pixelToNdc(exact, view.size), viewDepth(view.projection, depth));
  return depth > 0.0 || view.projection.kind == kOrthographic;
}

float occlusionRadius() { return kWorlds != 0u ? frameOf(push.frame, gl_WorkGroupID.z).aoRadius : push.radius; }

// The occluded fraction of half a slice. The amount by which each sample raises the horizon is weighted by the sample's
// distance. A sample blocks later samples only in proportion to its own weight, so the result is continuous when an
// occluder leaves the radius.
float occludedArc(View view, Center c, vec2 direction, SliceNormal n, vec2 steps) {
  float visible = wholeArc(n), occluded = 0.0, before = 0.0;
  for (uint i = 0u; i < kStepsPerSide; ++i) {
    float t = (float(i) + steps.x) / float(kStepsPerSide);
    vec3 position;
    float along = 1.0 + t * t * steps.y;
    bool there = sampleAt(view, c, direction * along, position);
    vec3 delta = position - c.position;
    float distance = length(delta);
    float cosine = clamp(dot(delta, c.toEye) / max(distance, 1.0e-30), -1.0, 1.0);
    // The occluder of the sky between the previous horizon and this one lies between the two samples.
    float nearer = distance * 0.5 * (1.0 + before / along);
    before = along;
    float weight = there && abovePlane(n, cosine) ? occlusionFalloff(nearer, occlusionRadius()) : 0.0;
    float arc = visibleArc(n, cosine);
    if (weight > 0.0 && arc < visible) {
      occluded += weight * (visible - arc);
      visible = mix(visible, arc, min(4.0 * weight, 1.0));
    }
  }
  return occluded;
}

SliceNormal sliceNormal(vec3 normal, vec3 toEye, vec3 tangent) {
  vec2 n = vec2(max(dot(normal, toEye), 0.0), dot(normal, tangent));
  n /= max(length(n), 1.0e-20);
  return SliceNormal(n.y < 0.0 ? -quickAcos(n.x) : quickAcos(n.x), n.x, n.y);
}

// The occluded fraction of the slice at `angle` in the picture, in both directions.
float occludedSlice(View view, Center c, vec3 normal, float angle, vec2 steps) {
  vec2 direction = vec2(cos(angle), sin(angle));  // pixels, y down
  // The view-space direction that projects to `direction`, then made perpendicular to V, the direction to the eye.
  vec3 across = vec3(direction.x / (view.projection.H * view.size.x), 0.0,
                     -direction.y / (view.projection.V * view.size.y));
  if (kLens != 0u) across = direction.x * c.right + direction.y * c.down;
  vec3 tangent = normalize(across - c.toEye * dot(across, c.toEye));
  vec3 axis = cross(c.toEye, tangent);
  float length = length(normal - axis * dot(normal, axis));
  SliceNormal forward = sliceNormal(normal, c.toEye, tangent);
  SliceNormal backward = SliceNormal(-forward.angle, forward.cosine, -forward.sine);
  return length * (occludedArc(view, c, direction, forward, steps) + occludedArc(view, c, -direction, backward, steps));
}

// The occluded fraction of the cosine-weighted hemisphere. Its average over a block is in [0, 1].
float occlusionAt(View view, Center c, vec3 normal) {
  float metre = view.projection.V * view.size.y * 0.5 / (view.projection.kind == kPerspective ? c.position.y : 1.0);
  if (kLens != 0u) metre = 1.0 / (length(c.position) * c.pixelAngle);
  float pixels = min(occlusionRadius() * metre, push.reach);
  if (pixels <= 1.0) return 0.0;
  // Two permutations of the block's 16 pixels: one for directions, one for the offsets of the steps along them.
  uint x = uint(c.place.x) & 3u, y = uint(c.place.y) & 3u;
  float turn = (float((x + y & 3u) * 4u + y) + 0.5) / 16.0;
  float start = (float(((x + 2u * y) & 3u) * 4u + (x ^ y)) + 0.5) / 16.0;
  float occluded = 0.0;
  for (uint i = 0u; i < kSlicesPerPixel; ++i)
    occluded += occludedSlice(view, c, normal, kPi * (float(i) + turn) / float(kSlicesPerPixel), vec2(start,
                                                                                                      pixels - 1.0));
  return occluded / float(kSlicesPerPixel);
}
