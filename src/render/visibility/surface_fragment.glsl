// The Surface that a fragment shows: for shaders that come after the depth pass. After varyings.glsl.
#include "render/visibility/fragment_point.glsl"
#include "render/glsl/surface.glsl"

#ifdef MULTISAMPLED
// A shader that says which samples it leaves would else run before the depth test, and here that has the last word: no
// depth is written.
layout(early_fragment_tests) in;
#endif
