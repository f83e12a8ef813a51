// Whether two samples of a pixel, or two of its triangles, show one surface: the triangles of a smooth mesh do, and so does
// one texture. They do if the first one's plane, extended, passes near the second one's position, and normals, materials
// and emitted light are similar. After gbuffer_read.glsl.
#ifndef LATELIGHT_SAME_SURFACE_GLSL
#define LATELIGHT_SAME_SURFACE_GLSL

// Differences that one surface may have within a pixel. Looser thresholds miss edges, tighter ones take curved surfaces
// and textures for edges: docs/antialiasing.md has the cost and error of these.
const float kMinCosine = 0.97;  // of two normals: 14 degrees
const float kMaxAlbedo = 0.06;   // linear colour, f0, metalness times a half
const float kMaxRoughness = 0.12;
const float kMaxOcclusion = 0.12;
const float kMaxEmitted = 0.06;  // of the brighter one, and of white
const float kMaxOffset = 1.5;    // from the plane, pixels
const float kMaxSlope = 0.1;     // and of the distance between the two

struct Sample {
  float depth;
  vec4 light;
  Surface s;
};

// The size of a pixel at that depth, metres.
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
