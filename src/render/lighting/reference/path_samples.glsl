// The sample sequence of a path.
#ifndef LATELIGHT_PATH_SAMPLES_GLSL
#define LATELIGHT_PATH_SAMPLES_GLSL
#include "render/glsl/sobol.glsl"

uint pathSeed;   // of the pixel
uint pathIndex;  // number of the sample
uint pathPair;   // the next pair of dimensions
vec2 nextSample() { return sobolSample(pathIndex, pathPair++, pathSeed); }

#endif
