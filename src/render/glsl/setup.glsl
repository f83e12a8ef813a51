// The specialization constants of a frame's shaders, set by render::FrameConfig::constants(). A shader's own constants
// start at kFirstOwnConstant (16).
#ifndef LATELIGHT_SETUP_GLSL
#define LATELIGHT_SETUP_GLSL
layout(constant_id = 0) const uint kNormalEncoding = 0;
layout(constant_id = 1) const uint kShading = 0;
layout(constant_id = 2) const uint kCountLights = 0;
layout(constant_id = 3) const uint kNormalSpace = 0;
layout(constant_id = 4) const uint kPositionMethod = 0;
layout(constant_id = 5) const uint kShadowFormat = 0;  // kShadow* of shared/shadow.h
layout(constant_id = 6) const uint kShadowFilter = 0;  // kShadowFilter*
layout(constant_id = 9) const uint kSunInGbuffer = 0;  // FrameConfig::sunInGbuffer
layout(constant_id = 7) const uint kEverySample = 0;
layout(constant_id = 11) const uint kLights = 1;  // FrameConfig::lights
layout(constant_id = 13) const uint kAmbientOcclusion = 0;
layout(constant_id = 90) const uint kEnvironment = 1;  // FrameConfig::environment
layout(constant_id = 91) const uint kFewLights = 0;    // FrameConfig::fewLights
#endif
