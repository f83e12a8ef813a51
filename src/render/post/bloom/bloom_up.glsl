// Bloom: doubles the size of a level with a 3x3 tent filter over bilinear taps (Jimenez 2014). Along each axis the
// weights of four texels are 1, 5, 7 and 3 sixteenths for one of the two new texels, and their mirror image for the
// other. The filter is separable: the invocations of a workgroup share the coarse texels and then the horizontally
// enlarged rows.
const int kSide = 16;
const int kCoarse = kSide / 2 + 4;
layout(local_size_x = kSide, local_size_y = kSide) in;
shared vec3 coarseTexels[kCoarse * kCoarse];
shared vec3 enlargedRows[kCoarse * kSide];

// The index of the first of the four source texels of a texel along one axis, relative to the first shared texel.
int firstOf(int texel) { return (texel >> 1) + (texel & 1); }

float tent(int texel, int i) {
  const float kTent[4] = float[](1.0 / 16.0, 5.0 / 16.0, 7.0 / 16.0, 3.0 / 16.0);
  return kTent[(texel & 1) == 0 ? i : 3 - i];
}

// Returns the enlarged value at the invocation's texel. Every invocation of the workgroup must call it.
vec3 enlarged(sampler2DArray coarse) {
  ivec2 size = textureSize(coarse, 0).xy, first = ivec2(gl_WorkGroupID.xy) * (kSide / 2) - 2;
  int own = int(gl_LocalInvocationIndex);
  for (int i = own; i < kCoarse * kCoarse; i += kSide * kSide) {
    ivec2 place = mirrored(first + ivec2(i % kCoarse, i / kCoarse), size);
    coarseTexels[i] = texelFetch(coarse, ivec3(place, gl_GlobalInvocationID.z), 0).rgb;
  }
  barrier();
  for (int i = own; i < kCoarse * kSide; i += kSide * kSide) {
    int x = i % kSide, from = i / kSide * kCoarse + firstOf(x);
    vec3 sum = vec3(0.0);
    for (int tap = 0; tap < 4; ++tap) sum += tent(x, tap) * coarseTexels[from + tap];
    enlargedRows[i] = sum;
  }
  barrier();
  ivec2 local = ivec2(gl_LocalInvocationID.xy);
  vec3 sum = vec3(0.0);
  for (int tap = 0; tap < 4; ++tap) sum += tent(local.y, tap) * enlargedRows[(firstOf(local.y) + tap) * kSide + local.x];
  return sum;
}
