#version 460
#extension GL_GOOGLE_include_directive : require
// Light volumes: places a vertex of a light's volume mesh, which is a sphere, a cone or a full-screen triangle
// (volume_mesh.h), around the light that is in the push constants.
#include "render/glsl/common.glsl"
#include "render/lighting/volumes/volume_push.h"

layout(push_constant, scalar) uniform Push { VolumePush push; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ShapeRef { vec3 v[]; };

// Margin for the angle computed from spotOffset / spotScale. Their rounding changes the angle of a narrow cone by up to
// 3.5e-4 radians.
const float kAngleMargin = 1e-3;
const float kLengthMargin = 0.01;  // relative to the radius, as kVolumeMargin in volume_mesh.h

// A vertex of the cone about +z with its tip at the origin. For the rings see kConeTip, kConeRim, kConeTop in
// volume_mesh.h.
vec3 coneVertex(vec3 v, Light light) {
  float angle = acos(clamp(-light.spotOffset / light.spotScale, -1.0, 1.0)) + kAngleMargin;
  vec2 rim = vec2(sin(angle), cos(angle));  // distance from the axis and along it
  vec2 top = vec2(tan(0.5 * angle), 1.0 + kLengthMargin);
  vec2 profile = v.z < 0.5 ? vec2(0.0, -kLengthMargin) : v.z < 1.5 ? rim : top;
  return vec3(v.xy * profile.x, profile.y) * push.radius;
}

vec3 rotateFromAxis(vec3 v, vec3 axis) {
  vec3 other = abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
  vec3 x = normalize(cross(other, axis));
  return x * v.x + cross(axis, x) * v.y + axis * v.z;
}

void main() {
  if (push.shape == kShapeScreen) {
    gl_Position = vec4(vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 4.0 - 1.0, 0.0, 1.0);
    return;
  }
  vec3 v = ShapeRef(push.vertices).v[gl_VertexIndex];
  if (push.shape == kShapeCone)
    v = rotateFromAxis(coneVertex(v, push.light), push.light.direction);
  else
    v *= push.radius;
  View view = frameView(FrameRef(push.frame).v, push.view);
  gl_Position = projectToClip(view.projection, view.worldToView * vec4(push.light.position + v, 1.0));
}
