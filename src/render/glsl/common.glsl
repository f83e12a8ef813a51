// Every shader's first include (after #version): extensions, shared headers, scene data by address.
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#ifdef TEXTURES_BY_INDEX
#extension GL_EXT_nonuniform_qualifier : require  // arrays without a size
#endif

#include "shared/types.h"

// Of the device (vk/pipeline.h).
layout(constant_id = 100) const uint kCpuDevice = 0;  // 1 on CPU devices
layout(constant_id = 101) const uint kSubgroupSize = 128;  // lanes of a subgroup, at most

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer FrameRef { FrameConstants v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewRef { View v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer InstanceRef { Instance v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer MeshRef { Mesh v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MaterialRef { Material v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightRef { vec4 v[4]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ShadowMapRef { ShadowMap v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ShadowBitsRef { ShadowBits v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightShadowRef { LightShadow v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightTreeRef { LightBox v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PositionRef { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer AttributesRef { VertexAttributes v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ExtraRef { VertexExtra v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintRef { uint v[]; };

View frameView(FrameConstants frame, uint index) { return ViewRef(frame.views).v[index]; }
Instance frameInstance(FrameConstants frame, uint index) { return InstanceRef(frame.instances).v[index]; }
Mesh frameMesh(FrameConstants frame, uint index) { return MeshRef(frame.meshes).v[index]; }
uvec3 triangleIndices(Mesh mesh, uint triangle) {
  UintRef indices = UintRef(mesh.indices);
  return uvec3(indices.v[3u * triangle], indices.v[3u * triangle + 1u], indices.v[3u * triangle + 2u]);
}
Material frameMaterial(FrameConstants frame, uint index) { return MaterialRef(frame.materials).v[index]; }
// In loads of 16 bytes: compilers make one of each member.
Light frameLight(FrameConstants frame, uint index) {
  LightRef light = LightRef(frame.lights + uint64_t(index) * 64u);
  vec4 a = light.v[0], b = light.v[1], c = light.v[2], d = light.v[3];
  Light l;
  l.position = a.xyz;
  l.inverseRadius2 = a.w;
  l.intensity = b.xyz;
  l.type = floatBitsToUint(b.w);
  l.direction = c.xyz;
  l.radius = c.w;
  l.spotScale = d.x;
  l.spotOffset = d.y;
  return l;
}
LightBox frameLightBox(FrameConstants frame, uint node) { return LightTreeRef(frame.lightTree).v[node]; }
