#version 460
// Reads one member of every struct that the scene's buffers hold, so that their layouts stand in the SPIR-V.
#extension GL_GOOGLE_include_directive : require
#include "render/glsl/common.glsl"

layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push {
  FrameRef frame;
  AttributesRef attributes;
  ExtraRef extras;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer SinkRef { float v[]; };

void main() {
  FrameConstants f = frame.v;
  Material material = frameMaterial(f, 0u);
  float sum = frameView(f, 0u).size.x + frameInstance(f, 0u).objectToWorld[0].x + material.roughness +
              material.transforms[0].row0.x + frameLight(f, 0u).reach + frameLightBox(f, 0u).low.x +
              float(frameMesh(f, 0u).vertexCount);
  SinkRef(f.views).v[0] = sum + attributes.v[0].uv0.x + extras.v[0].uv1.x;
}
