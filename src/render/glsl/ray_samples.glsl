// Sample points for rays. A sequence is fixed and starts at a point that depends only on where it is used, so images do
// not depend on how they are split into views, strips and samples.
#ifndef LATELIGHT_RAY_SAMPLES_GLSL
#define LATELIGHT_RAY_SAMPLES_GLSL

// PCG hash of three integers (Jarzynski and Olano 2020, Hash Functions for GPU Rendering, JCGT 9(3)).
uvec3 rayHash(uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v += v.yzx * v.zxy;
  v ^= v >> 16u;
  v += v.yzx * v.zxy;
  return v;
}

// In [0, 1).
vec2 rayUnit(uvec2 bits) { return vec2(bits >> 8u) * (1.0 / 16777216.0); }

// Returns the start of the sequence at a position in the device's world space.
vec2 raySeed(vec3 position) { return rayUnit(rayHash(floatBitsToUint(position)).xy); }

// Returns point i of the sequence R2, a lattice by powers of the plastic number (Roberts 2018, The Unreasonable
// Effectiveness of Quasirandom Sequences).
vec2 raySample(vec2 start, uint i) {
  // 2^32 times the steps: integers wrap without rounding.
  uvec2 steps = uvec2(3242174889u, 2447445414u) * i;
  return fract(start + rayUnit(steps));
}

// Maps the unit square to the unit disk, areas to areas (Shirley and Chiu 1997, A Low Distortion Map Between Disk and
// Square).
vec2 diskSample(vec2 u) {
  vec2 v = 2.0 * u - 1.0;
  bool wide = abs(v.x) > abs(v.y);
  float radius = wide ? v.x : v.y;
  float angle = radius == 0.0 ? 0.0 : 0.78539816 * (wide ? v.y / v.x : 2.0 - v.x / v.y);
  return radius * vec2(cos(angle), sin(angle));
}

// Returns the distance in meters by which a ray's origin is moved off its surface: what a position may be away from its
// surface, after it was reconstructed from depth at a distance from the eye, and rounded.
float rayOffset(vec3 position, float fromEye) {
  return 5e-5 * fromEye + 4e-7 * (abs(position.x) + abs(position.y) + abs(position.z));
}

#endif
