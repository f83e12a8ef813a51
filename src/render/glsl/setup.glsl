// The specialization constants of a frame's shaders, set by render::FrameConfig::constants().
#ifndef LATELIGHT_SETUP_GLSL
#define LATELIGHT_SETUP_GLSL
layout(constant_id = kNormalEncodingConstant) const uint kNormalEncoding = 0;
layout(constant_id = kShadingConstant) const uint kShading = 0;
layout(constant_id = kCountLightsConstant) const uint kCountLights = 0;
layout(constant_id = kNormalSpaceConstant) const uint kNormalSpace = 0;
layout(constant_id = kPositionMethodConstant) const uint kPositionMethod = 0;
layout(constant_id = kShadowFormatConstant) const uint kShadowFormat = 0;  // kShadow* of shared/shadow.h
layout(constant_id = kShadowFilterConstant) const uint kShadowFilter = 0;  // kShadowFilter*
layout(constant_id = kSunInGbufferConstant) const uint kSunInGbuffer = 0;  // FrameConfig::sunInGbuffer
layout(constant_id = kEverySampleConstant) const uint kEverySample = 0;
layout(constant_id = kLightsConstant) const uint kLights = 1;  // FrameConfig::lights
layout(constant_id = kAmbientOcclusionConstant) const uint kAmbientOcclusion = 0;
layout(constant_id = kEnvironmentConstant) const uint kEnvironment = 1;  // kEnvironment* of shared/environment.h
layout(constant_id = kFewLightsConstant) const uint kFewLights = 0;      // FrameConfig::fewLights
layout(constant_id = kAreaLightsConstant) const uint kAreaLights = 0;    // FrameConfig::areaLights
#endif
