// What the shaders of sun_occlusion.cpp are pushed.
struct SunPush {
  uint64_t frame;  // FrameConstants
  uint view;
  Light sun;
};
layout(push_constant, scalar) uniform Push { SunPush push; };
