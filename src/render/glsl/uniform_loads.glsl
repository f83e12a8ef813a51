// Loads of a frame's constants and of a view by all invocations of a subgroup together, for compute shaders. Every
// invocation of the subgroup must call these functions, with the same arguments.
//
// On lavapipe a load by address is a loop over lanes, even if all lanes load the same word, but a shuffle is one
// instruction. There, each lane loads a different word, and the lanes exchange them. GPUs load uniform words at once.
#ifndef LATELIGHT_UNIFORM_LOADS_GLSL
#define LATELIGHT_UNIFORM_LOADS_GLSL
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer LongsRef { uint64_t v[]; };

const bool kSharesLoads = kCpuDevice != 0u && kSubgroupSize >= 8u;
uint loadingLane() { return gl_SubgroupInvocationID & 7u; }

uvec2 longAt(uint64_t address, uint index) { return unpackUint2x32(LongsRef(address).v[index]); }
uvec2 exchanged(uvec2 own, uint lane) { return uvec2(subgroupShuffle(own.x, lane), subgroupShuffle(own.y, lane)); }
vec2 exchangedFloats(uvec2 own, uint lane) { return uintBitsToFloat(exchanged(own, lane)); }

// As frameOf(). The members that only some shaders use are loaded as usual.
FrameConstants uniformFrame(uint64_t frames, uint view) {
  FrameConstants frame = frameOf(frames, view);
  if (!kSharesLoads) return frame;
  uint lane = loadingLane();
  // The members from viewCount on, then `views` and `lights`.
  uint index = lane < 6u ? kFrameCountsAt + lane : lane == 6u ? 0u : kFrameLightsAt;
  uvec2 own = longAt(kWorlds != 0u ? frames + uint64_t(view) * kFrameBytes : frames, index);
  uvec2 counts = exchanged(own, 0u), tree = exchanged(own, 1u), columns = exchanged(own, 2u);
  vec2 environment = exchangedFloats(own, 3u), further = exchangedFloats(own, 4u);
  frame.viewCount = counts.x;
  frame.lightCount = counts.y;
  frame.directionalLights = tree.x;
  frame.lightTreeLeaves = tree.y;
  frame.shadowColumns = columns.x;
  frame.exposure = uintBitsToFloat(columns.y);
  frame.environmentIntensity = environment.x;
  frame.environmentCos = environment.y;
  frame.environmentSin = further.x;
  frame.aoRadius = further.y;
  frame.environmentLevels = exchangedFloats(own, 5u).x;
  frame.views = packUint2x32(exchanged(own, 6u));
  frame.lights = packUint2x32(exchanged(own, 7u));
  return frame;
}

mat4x3 exchangedMatrix(uvec2 own) {
  vec2 a = exchangedFloats(own, 0u), b = exchangedFloats(own, 1u), c = exchangedFloats(own, 2u);
  vec2 d = exchangedFloats(own, 3u), e = exchangedFloats(own, 4u), f = exchangedFloats(own, 5u);
  return mat4x3(a, b, c, d, e, f);
}

// As frameView().
View uniformView(FrameConstants frame, uint index) {
  if (!kSharesLoads) return frameView(frame, index);
  uint64_t at = frame.views + uint64_t(index) * kViewBytes;
  uint lane = loadingLane();
  uvec2 first = longAt(at, lane), second = longAt(at, 6u + lane), third = longAt(at, 14u + lane);
  vec2 scales = exchangedFloats(second, 6u), depth = exchangedFloats(second, 7u);
  vec2 principal = exchangedFloats(third, 0u);
  uvec2 kind = exchanged(third, 1u), group = exchanged(third, 5u);
  View v;
  v.worldToView = exchangedMatrix(first);
  v.viewToWorld = exchangedMatrix(second);
  v.projection = Projection(scales.x, scales.y, depth.x, depth.y, principal.x, principal.y, kind.x);
  v.eye = vec3(uintBitsToFloat(kind.y), exchangedFloats(third, 2u));
  v.size = exchangedFloats(third, 3u);
  v.jitter = exchangedFloats(third, 4u);
  v.group = group.x;
  v.eyeLow = vec3(uintBitsToFloat(group.y), exchangedFloats(third, 6u));
  return v;
}

#endif
