// Bloom: enlarges a level to the size of the next finer one. A new texel is the mean, over its area, of the level's
// bilinear interpolation after a 3x3 tent filter (Jimenez 2014). If the finer level has twice as many texels along an
// axis, the weights of the coarse texels are 1, 5, 7, 3 and 0 sixteenths for one of the two new texels, and their
// mirror image for the other. The filter is separable: the invocations of a workgroup share the coarse texels and then
// the horizontally enlarged rows.
const int kSide = 16;
const int kTaps = 5;
// Levels of at least 17 texels shrink to at most 9/17, so that the centers of 16 texels extend over at most 9 coarse
// ones. Smaller levels shrink to at most 8 texels.
const int kCoarse = kSide / 2 + kTaps;
layout(local_size_x = kSide, local_size_y = kSide) in;
shared vec3 coarseTexels[kCoarse * kCoarse];
shared vec3 enlargedRows[kCoarse * kSide];

ivec2 mirrored(ivec2 p, ivec2 size) {
  p = mix(p, -1 - p, lessThan(p, ivec2(0)));
  p = mix(p, 2 * size - 1 - p, greaterThanEqual(p, size));
  return clamp(p, ivec2(0), size - 1);  // for levels smaller than the filter
}

// The index of the first of the kTaps coarse texels of a fine texel along one axis. `fine` and `coarse` are the sizes.
int firstOf(int texel, int fine, int coarse) { return texel * coarse / fine - kTaps / 2; }

// The weights of the coarse texels of a fine texel along one axis.
float[kTaps] tent(int texel, int fine, int coarse) {
  // The fine texel is from `start` to `end` in the middle one of these coarse texels, or ends in the one after it.
  float start = float(texel * coarse % fine) / float(fine), end = start + float(coarse) / float(fine);
  // The means of the linear interpolation's weights. They are 1 at centers of coarse texels, at -0.5, 0.5 and 1.5.
  vec2 before = max(0.5 - vec2(start, end), 0.0), after = max(vec2(start, end) - 0.5, 0.0);
  float a = (before.x * before.x - before.y * before.y) / (2.0 * (end - start));
  float c = (after.y * after.y - after.x * after.x) / (2.0 * (end - start));
  float b = 1.0 - a - c;
  return float[](0.25 * a, 0.25 * b + 0.5 * a, 0.5 * b + 0.25 * (a + c), 0.25 * b + 0.5 * c, 0.25 * c);
}

// Returns the enlarged value at the invocation's texel of a level of size `fine`. Every invocation of the workgroup
// must call it.
vec3 enlarged(sampler2DArray coarse, ivec2 fine) {
  ivec2 size = textureSize(coarse, 0).xy, group = ivec2(gl_WorkGroupID.xy) * kSide;
  ivec2 first = ivec2(firstOf(group.x, fine.x, size.x), firstOf(group.y, fine.y, size.y));
  int own = int(gl_LocalInvocationIndex);
  for (int i = own; i < kCoarse * kCoarse; i += kSide * kSide) {
    ivec2 place = mirrored(first + ivec2(i % kCoarse, i / kCoarse), size);
    coarseTexels[i] = texelFetch(coarse, ivec3(place, gl_GlobalInvocationID.z), 0).rgb;
  }
  barrier();
  for (int i = own; i < kCoarse * kSide; i += kSide * kSide) {
    int x = min(group.x + i % kSide, fine.x - 1);
    int from = i / kSide * kCoarse + firstOf(x, fine.x, size.x) - first.x;
    float[kTaps] weights = tent(x, fine.x, size.x);
    vec3 sum = vec3(0.0);
    for (int tap = 0; tap < kTaps; ++tap) sum += weights[tap] * coarseTexels[from + tap];
    enlargedRows[i] = sum;
  }
  barrier();
  int y = min(int(gl_GlobalInvocationID.y), fine.y - 1), from = firstOf(y, fine.y, size.y) - first.y;
  float[kTaps] weights = tent(y, fine.y, size.y);
  vec3 sum = vec3(0.0);
  for (int tap = 0; tap < kTaps; ++tap)
    sum += weights[tap] * enlargedRows[(from + tap) * kSide + int(gl_LocalInvocationID.x)];
  return sum;
}
