// The first include of every shader (after #version): extensions, shared headers, and scene data by buffer reference.
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#ifdef TEXTURES_BY_INDEX
#extension GL_EXT_nonuniform_qualifier : require  // unsized arrays
#endif

#include "constant_ids.glsl"  // the ids of specialization constants (vk/constant_id.h)
#include "shared/types.h"

// Properties of the device (vk/constants.def).
layout(constant_id = kCpuDeviceConstant) const uint kCpuDevice = 0;         // 1 on CPU devices
layout(constant_id = kSubgroupSizeConstant) const uint kSubgroupSize = 128;  // maximum lanes of a subgroup

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer FrameRef { FrameConstants v; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer WordsRef { u64vec2 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer MeshRef { Mesh v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer MaterialRef { Material v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ShadowBitsRef { ShadowBits v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightShadowRef { LightShadow v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer LightTreeRef { LightBox v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ExtraRef { VertexExtra v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintRef { uint v[]; };

// 1: each view has its own constants (FrameConstants).
layout(constant_id = kWorldsConstant) const uint kWorlds = 0;

// Returns the constants of a view. `frames`: those of the frame, as passed to compute shaders. A draw is passed those
// of its view.
FrameConstants frameOf(uint64_t frames, uint view) {
  return FrameRef(kWorlds != 0u ? frames + uint64_t(view) * kFrameBytes : frames).v;
}

Mesh frameMesh(FrameConstants frame, uint index) { return MeshRef(frame.meshes).v[index]; }
uvec3 triangleIndices(Mesh mesh, uint triangle) {
  UintRef indices = UintRef(mesh.indices);
  return uvec3(indices.v[3u * triangle], indices.v[3u * triangle + 1u], indices.v[3u * triangle + 2u]);
}
LightBox frameLightBox(FrameConstants frame, uint node) { return LightTreeRef(frame.lightTree).v[node]; }

// --- common loads ----------------------------------------------------------------------------------------------------
//
// These functions load 16 bytes at once, because compilers otherwise emit one load per member, and as 64-bit words,
// because on lavapipe each load is a loop over lanes.

uvec4 wordsAt(uint64_t address, uint i) {
  u64vec2 words = WordsRef(address).v[i];
  return uvec4(unpackUint2x32(words.x), unpackUint2x32(words.y));
}
vec4 floatsAt(uint64_t address, uint i) { return uintBitsToFloat(wordsAt(address, i)); }
mat4x3 matrixAt(uint64_t address, uint i) {
  vec4 a = floatsAt(address, i), b = floatsAt(address, i + 1u), c = floatsAt(address, i + 2u);
  return mat4x3(a, b, c);
}

// Vertex streams of a mesh.
vec3 positionAt(uint64_t positions, uint vertex) {
  return floatsAt(positions + uint64_t(vertex) * kPositionBytes, 0u).xyz;
}
VertexAttributes attributesAt(uint64_t attributes, uint vertex) {
  uint64_t at = attributes + uint64_t(vertex) * kAttributesBytes;
  vec4 a = floatsAt(at, 0u), b = floatsAt(at, 1u);
  return VertexAttributes(a.xyz, vec4(a.w, b.xyz), vec2(b.w, floatsAt(at, 2u).x), float[3](0.0, 0.0, 0.0));
}

View viewAt(uint64_t views, uint index) {
  uint64_t at = views + uint64_t(index) * kViewBytes;
  vec4 scales = floatsAt(at, 6u), principal = floatsAt(at, 7u), eye = floatsAt(at, 8u), jitter = floatsAt(at, 9u);
  vec4 low = floatsAt(at, 10u);
  View v;
  v.worldToView = matrixAt(at, 0u);
  v.viewToWorld = matrixAt(at, 3u);
  v.projection = Projection(scales.x, scales.y, scales.z, scales.w, principal.x, principal.y,
                            floatBitsToUint(principal.z));
  v.eye = vec3(principal.w, eye.xy);
  v.size = eye.zw;
  v.jitter = jitter.xy;
  v.group = floatBitsToUint(jitter.z);
  v.eyeLow = vec3(jitter.w, low.xy);
  return v;
}
View frameView(FrameConstants frame, uint index) { return viewAt(frame.views, index); }

Instance instanceAt(uint64_t instances, uint index) {
  uint64_t at = instances + uint64_t(index) * kInstanceBytes;
  uvec4 numbers = wordsAt(at, 3u);
  Instance i;
  i.objectToWorld = matrixAt(at, 0u);
  i.mesh = numbers.x;
  i.material = numbers.y;
  i.id = numbers.z;
  i.part = numbers.w;
  uvec4 rest = wordsAt(at, 4u);
  i.flags = rest.x;
  i.translationLow = uintBitsToFloat(rest.yzw);
  return i;
}
Instance frameInstance(FrameConstants frame, uint index) { return instanceAt(frame.instances, index); }

// Camera-relative rendering: returns the transform from object space to positions relative to the eye, in world axes.
// The eye and the instance may be far from the origin, so large terms are subtracted before anything is rounded.
mat4x3 relativeToEye(Instance instance, vec3 eye, vec3 eyeLow) {
  mat4x3 m = instance.objectToWorld;
  precise vec3 offset = (m[3] - eye) + (instance.translationLow - eyeLow);
  m[3] = offset;
  return m;
}
mat4x3 relativeToEye(Instance instance, View view) { return relativeToEye(instance, view.eye, view.eyeLow); }

// Transforms a position relative to the eye to view space.
vec3 toView(View view, vec3 relative) { return mat3(view.worldToView) * relative; }
// The inverse of toView(). The rows of a shadow map's rotation may have a common scale.
vec3 toWorldAxes(View view, vec3 seen) {
  mat3 m = mat3(view.worldToView);
  return transpose(m) * seen / dot(m[0], m[0]);
}

// Returns the offset from one eye to the other, in world axes.
vec3 eyeBetween(View from, View to) {
  precise vec3 between = (to.eye - from.eye) + (to.eyeLow - from.eyeLow);
  return between;
}

// Texture transforms, images and coats are loaded only where they are used.
Material frameMaterial(FrameConstants frame, uint index) {
  uint64_t at = frame.materials + uint64_t(index) * kMaterialBytes;
  vec4 emissive = floatsAt(at, 1u), factors = floatsAt(at, 2u), specular = floatsAt(at, 3u);
  uvec4 numbers = wordsAt(at, 4u);
  Material m = MaterialRef(at).v;
  m.baseColor = floatsAt(at, 0u);
  m.emissive = emissive.xyz;
  m.metallic = emissive.w;
  m.roughness = factors.x;
  m.normalScale = factors.y;
  m.occlusionStrength = factors.z;
  m.alphaCutoff = factors.w;
  m.specularColor = specular.xyz;
  m.specular = specular.w;
  m.f0 = uintBitsToFloat(numbers.x);
  m.flags = numbers.y;
  m.textures = numbers.z;
  m.id = numbers.w;
  return m;
}

Light frameLight(FrameConstants frame, uint index) {
  uint64_t at = frame.lights + uint64_t(index) * kLightBytes;
  vec4 a = floatsAt(at, 0u), b = floatsAt(at, 1u), c = floatsAt(at, 2u), d = floatsAt(at, 3u);
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

ShadowMap frameShadowMap(FrameConstants frame, uint index) {
  uint64_t at = frame.shadowMaps + uint64_t(index) * kShadowMapBytes;
  vec4 depth = floatsAt(at, 3u), kind = floatsAt(at, 4u), tile = floatsAt(at, 5u);
  ShadowMap m;
  m.across = floatsAt(at, 0u);
  m.down = floatsAt(at, 1u);
  m.away = floatsAt(at, 2u);
  m.depthScale = depth.x;
  m.depthOffset = depth.y;
  m.depthSlack = depth.z;
  m.texel = depth.w;
  m.perspective = kind.x;
  m.lightSize = kind.y;
  m.corner = floatBitsToUint(kind.zw);
  m.size = tile.x;
  m.layer = floatBitsToUint(tile.y);
  return m;
}
