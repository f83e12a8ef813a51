// Decides whether two samples or two triangles of a pixel show one surface, such as a smooth mesh or a textured area:
// the first one's plane passes near the second one's position, and normals, materials and emitted light are similar.
// Include after gbuffer_read.glsl.
#ifndef LATELIGHT_SAME_SURFACE_GLSL
#define LATELIGHT_SAME_SURFACE_GLSL

// Maximum differences within one surface of a pixel. Looser thresholds miss edges; tighter ones treat curved surfaces
// and textures as edges. docs/antialiasing.md states their cost and error.
const float kMinCosine = 0.97;  // between normals: 14 degrees
const float kMaxAlbedo = 0.06;   // linear color, f0, half the metalness
const float kMaxRoughness = 0.12;
const float kMaxOcclusion = 0.12;
const float kMaxEmitted = 0.06;  // relative to the brighter one, at least to white
const float kMaxOffset = 1.5;    // distance from the plane, in pixels
const float kMaxSlope = 0.1;     // additional distance from the plane, relative to the distance of the two points

struct Sample {
  float depth;
  vec4 light;
  Surface s;
};

// Returns the size of a pixel at a device depth, in meters.
float pixelSize(View view, float depth) {
  float size = 2.0 / (view.projection.V * view.size.y);
  return view.projection.kind == kPerspective ? size * viewDepth(view.projection, depth) : size;
}

float largest(vec3 v) {
  return max(v.x, max(v.y, v.z));
}

bool sameMaterial(Sample a, Sample b) {
  float albedo = max(largest(abs(a.s.baseColor - b.s.baseColor)), largest(abs(a.s.f0 - b.s.f0)));
  albedo = max(albedo, 0.5 * abs(a.s.metallic - b.s.metallic));
  bool same = albedo <= kMaxAlbedo && abs(a.s.roughness - b.s.roughness) <= kMaxRoughness;
  float brighter = max(largest(a.light.rgb), largest(b.light.rgb));
  same = same && largest(abs(a.light.rgb - b.light.rgb)) <= kMaxEmitted * max(brighter, 1.0);
  return same && abs(a.s.ao - b.s.ao) <= kMaxOcclusion && a.s.flags == b.s.flags;
}

bool sameSurface(Sample a, Sample b, float size) {
  vec3 between = b.s.position - a.s.position;
  float offset = abs(dot(between, a.s.normal));
  bool near = offset <= kMaxOffset * size + kMaxSlope * length(between);
  return near && dot(a.s.normal, b.s.normal) >= kMinCosine && sameMaterial(a, b);
}

#endif
