#version 460
#extension GL_GOOGLE_include_directive : require
// Depth of alpha-masked materials (glTF 2.0, section 3.9.4).
#include "render/glsl/common.glsl"
#include "render/glsl/varyings.glsl"
#include "render/glsl/material.glsl"

void main() {
  if (baseColor(material).a < material.alphaCutoff) discard;
}
