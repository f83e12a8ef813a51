// What a volume's shaders are pushed (volumes.cpp): one light, and no loads to get at it.
struct VolumePush {
  uint64_t frame;     // FrameConstants
  uint64_t vertices;  // vec3[]: volume_mesh.h
  uint view;
  uint shape;
  float reach;  // of the mesh, metres: the light's, or of one without an end how far the scene goes
  Light light;
};
layout(push_constant, scalar) uniform Push { VolumePush push; };

const uint kShapeScreen = 0u;  // one triangle over the whole picture, at depth 0: in front of nothing
const uint kShapeSphere = 1u;
const uint kShapeCone = 2u;
