#version 460
// functions: kept
// For the fuzz target `shader`: each kind of declaration that reflection reads, and each kind of branch that the removal
// of dead code follows.
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_nonuniform_qualifier : require

layout(local_size_x = 64) in;

layout(constant_id = 0) const uint kMode = 1;
layout(constant_id = 1) const bool kIsOn = true;
layout(constant_id = 2) const float kScale = 0.5;
const uint kCount = kMode * 3u + 1u;

struct Inner {
  mat3x4 place;
  vec3 color;
  uint flags[3];
};
layout(buffer_reference, std430) buffer Words { uint words[]; };
layout(push_constant, std430) uniform Push {
  Words words;
  vec2 scale;
  uint count;
} push;
layout(set = 0, binding = 0, rgba16f) uniform image2DArray target;
layout(set = 0, binding = 1) uniform sampler2D source;
layout(set = 0, binding = 2, std140) uniform Scene {
  mat4 worldFromView;
  Inner inner[4];
} scene;
layout(set = 0, binding = 3, r32ui) uniform uimage2D counters;
layout(set = 0, binding = 4, std430) buffer Results { vec4 results[]; };
layout(set = 0, binding = 5) uniform samplerBuffer texels;
layout(set = 1, binding = 0) uniform sampler2D textures[];

shared uint total;

vec4 fetch(uint index, out int exponent) {
  vec4 value = texture(textures[nonuniformEXT(index)], vec2(0.5));
  float whole = 0.0;
  value.x = modf(value.x * kScale, whole) + whole;
  value.y = frexp(value.y, exponent);
  return value;
}

uint choose(uint mode) {
  switch (mode) {
    case 0u: return 7u;
    case 1u:
    case 2u: return kIsOn ? 5u : 6u;
    default: break;
  }
  uint sum = 0u;
  for (uint i = 0u; i < kCount; ++i) {
    if ((i & 1u) == 1u) continue;
    if (i > 20u) break;
    sum += i >> 1u;
  }
  return sum;
}

void main() {
  int exponent = 0;
  uint mode = choose(kMode);
  vec4 value = fetch(mode, exponent);
  if (kIsOn && kMode != 3u) {
    value += texture(source, push.scale) * scene.inner[exponent & 3].place[1];
  } else {
    value += texelFetch(texels, exponent);
  }
  do {
    atomicAdd(total, push.words.words[mode]);
    imageAtomicAdd(counters, ivec2(mode), 1u);
  } while (total < push.count);
  results[mode % results.length()] = scene.worldFromView * value;
  imageStore(target, ivec3(0), value);
}
