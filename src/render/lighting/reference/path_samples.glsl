// The sample sequence of a path, and choices by its points.
#ifndef LATELIGHT_PATH_SAMPLES_GLSL
#define LATELIGHT_PATH_SAMPLES_GLSL
#include "render/glsl/sobol.glsl"

uint pathSeed;   // of the pixel
uint pathIndex;  // number of the sample
uint pathPair;   // the next pair of dimensions
vec2 nextSample() { return sobolSample(pathIndex, pathPair++, pathSeed); }

// Chooses one of several candidates in proportion to their weights, which are added one by one. Returns true if the
// added one takes the place of the one before. `pick`: a random number in [0, 1); `total`: of the weights, 0 before.
bool takesCandidate(inout float pick, inout float total, float weight) {
  weight = weight > 0.0 ? weight : 0.0;  // also if it is not a number
  total += weight;
  float kept = weight / max(total, 1e-30);
  bool taken = weight > 0.0 && pick < kept;
  pick = clamp(taken ? pick / kept : (pick - kept) / max(1.0 - kept, 1e-6), 0.0, 0.999999);
  return taken;
}

#endif
