// Texture filtering in shader code, for compute shaders on devices without descriptor indexing, such as lavapipe. Mip
// levels and filters follow Vulkan 1.3, sections 16.6 to 16.9.
#ifndef LATELIGHT_TEXELS_GLSL
#define LATELIGHT_TEXELS_GLSL
#include "render/glsl/lane_loops.glsl"
#include "shared/color.h"

#include "load/TextureRecord.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer TextureRef { TextureRecord v[]; };
TextureRecord textureAt(uint64_t records, uint index) {
  TextureRecord t;
  if (kTexelLoads != 0u) t = loadTextureRecord(records + uint64_t(index) * kTextureRecordBytes);
  else t = TextureRef(records).v[index];
  return t;
}

int wrapped(int at, int size, uint mode) {
  if (mode == 2u) return clamp(at, 0, size - 1);
  int period = mode == 1u ? 2 * size : size;
  int inside = at - period * int(floor(float(at) / float(period)));
  inside = clamp(inside, 0, period - 1);
  return inside < size ? inside : 2 * size - 1 - inside;
}

vec4 texelAt(TextureRecord t, uint index) {
  vec4 c = unpackUnorm4x8(sceneWordAt(t.texels, index));
  if ((t.flags & kTextureSrgb) != 0u) c.rgb = kCpuDevice != 0u ? linearFromByte(c.rgb) : linearFromSrgb(c.rgb);
  return c;
}

struct TextureLevel {
  uint first;  // texel
  ivec2 size;
};
TextureLevel nextLevel(TextureLevel l) {
  return TextureLevel(l.first + uint(l.size.x * l.size.y), max(l.size / 2, ivec2(1)));
}
TextureLevel levelOf(TextureRecord t, uint level) {
  TextureLevel l = TextureLevel(0u, ivec2(t.width, t.height));
  for (uint i = 0u; i < level; ++i) l = nextLevel(l);
  return l;
}

vec4 filteredLevel(TextureRecord t, TextureLevel l, vec2 uv, bool nearest) {
  vec2 at = uv * vec2(l.size) - (nearest ? 0.0 : 0.5);
  ivec2 low = ivec2(floor(at));
  vec2 share = nearest ? vec2(0.0) : at - floor(at);
  uint wrapU = t.flags >> kTextureWrapShift & 3u, wrapV = t.flags >> (kTextureWrapShift + 2u) & 3u;
  uint left = uint(wrapped(low.x, l.size.x, wrapU)), right = uint(wrapped(low.x + 1, l.size.x, wrapU));
  uint upper = l.first + uint(wrapped(low.y, l.size.y, wrapV) * l.size.x);
  uint lower = l.first + uint(wrapped(low.y + 1, l.size.y, wrapV) * l.size.x);
  return mix(mix(texelAt(t, upper + left), texelAt(t, upper + right), share.x),
             mix(texelAt(t, lower + left), texelAt(t, lower + right), share.x), share.y);
}

// Samples the finest level only.
vec4 magnifiedTexture(TextureRecord t, vec2 uv) {
  return filteredLevel(t, levelOf(t, 0u), uv, (t.flags & kTextureMagnifyNearest) != 0u);
}

struct Levels {
  uint first;   // the finer level
  float share;  // weight of the next level
  bool nearest;
};

Levels levelsAt(TextureRecord t, float level) {
  if (!(level > 0.0)) return Levels(0u, 0.0, (t.flags & kTextureMagnifyNearest) != 0u);
  bool nearest = (t.flags & kTextureMinifyNearest) != 0u;
  if ((t.flags & kTextureMipNone) != 0u) return Levels(0u, 0.0, nearest);
  level = min(level, float(t.levels - 1u));
  if ((t.flags & kTextureMipNearest) != 0u) return Levels(uint(ceil(level + 0.5) - 1.0), 0.0, nearest);
  return Levels(uint(level), fract(level), nearest);
}

// A loop with one call of filteredLevel(): lavapipe executes both sides of every branch, and texels dominate the time.
vec4 filteredAtLevel(TextureRecord t, vec2 uv, float level) {
  Levels levels = levelsAt(t, level);
  TextureLevel l = levelOf(t, levels.first);
  vec4 sum = vec4(0.0);
  uint i = 0u, count = levels.share > 0.0 ? 2u : 1u;
  do {
    vec4 c = filteredLevel(t, l, uv, levels.nearest);
    if (i < count) sum += (i == 0u ? 1.0 - levels.share : levels.share) * c;
    if (i + 1u < count) l = nextLevel(l);
  } while (lanesGoOn(++i < count));
  return sum;
}

// `t.anisotropy` is the maximum number of samples along the footprint; the level follows from the length per sample.
vec4 filteredTexture(TextureRecord t, vec2 uv, vec2 dx, vec2 dy) {
  vec2 size = vec2(t.width, t.height);
  float across = length(dx * size), down = length(dy * size);
  float longer = max(max(across, down), 1e-18), shorter = min(across, down);
  uint samples = uint(clamp(ceil(longer / max(shorter, 1e-18)), 1.0, float(max(t.anisotropy, 1u))));
  float level = log2(longer / float(samples));
  vec2 way = across >= down ? dx : dy;
  vec4 sum = vec4(0.0);
  uint i = 0u;
  do {
    vec4 c = filteredAtLevel(t, uv + way * ((float(i) + 0.5) / float(samples) - 0.5), level);
    if (i < samples) sum += c;
  } while (lanesGoOn(++i < samples));
  return sum / float(samples);
}

#endif
