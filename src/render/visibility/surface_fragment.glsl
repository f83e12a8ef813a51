// The Surface of a fragment, for shaders that run after the depth pass. Include after varyings.glsl.
#include "render/visibility/fragment_point.glsl"
#include "render/glsl/surface.glsl"

#ifdef MULTISAMPLED
// Early depth test: a shader that writes gl_SampleMask would otherwise run before the depth test. The early test is
// valid here because no depth is written.
layout(early_fragment_tests) in;
#endif
