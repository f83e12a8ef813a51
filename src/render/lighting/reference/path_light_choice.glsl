// One of the frame's lights for a surface of a path, in proportion to what each would add without shadows (Talbot,
// Cline and Egbert 2005, Importance Resampling for Global Illumination). The candidates are all lights of a small
// scene. Otherwise they are a few directional lights, and the lights of leaves of the light tree whose boxes contain
// the surface. A leaf is found from the root, by a child with equal probability among those whose boxes contain the
// surface (compare Conty Estevez and Kulla 2018, Importance Sampling of Many Lights with Adaptive Tree Splitting).
//
// Include after path_lobes.glsl, which defines reflectedLight().
#ifndef LATELIGHT_PATH_LIGHT_CHOICE_GLSL
#define LATELIGHT_PATH_LIGHT_CHOICE_GLSL
#include "render/glsl/setup.glsl"
#include "shared/light.h"

const uint kMaxCandidates = 32u;  // without the tree, and of the directional lights
const uint kLeavesPerChoice = 4u;

struct LightChoice {
  vec3 light;  // what the surface reflects of all lights, estimated by the chosen one, if nothing blocks it; 0: none
  vec3 arriving;  // intensity times attenuation at the surface, in the same estimate
  vec3 toLight;
  uint index;
  // While candidates are added:
  float pick;    // random number in [0, 1)
  float total;   // weight of all candidates
  float weight;  // of the chosen light, as if it were the only candidate
};

// Returns true if the light may reach the surface. Geometry nearer to a light than its radius is the light's own body.
// The light that it reflects is part of the light's intensity, so other surfaces do not receive it again.
bool lights(FrameConstants frame, PathVertex v, uint index) {
  if (index < frame.directionalLights) return true;
  uint64_t light = frame.lights + uint64_t(index) * kLightBytes;
  vec4 sphere = sceneFloatsAt(light, 0u);  // position, 1 / radius^2
  float size = v.visible ? 0.0 : sceneFloatsAt(light, 3u).z;
  vec3 offset = sphere.xyz - v.s.position;
  float distance2 = dot(offset, offset);
  return distance2 * sphere.w < 1.0 && distance2 >= size * size;
}

// Lights that are candidates together: [first, end), each of which stands for `count` lights.
struct CandidateRange {
  uint first, end;
  float count;
};

void addCandidates(inout LightChoice c, FrameConstants frame, PathVertex v, CandidateRange range) {
  uint i = range.first;
  do {
    if (i < range.end && lights(frame, v, i)) {
      LightSample arriving = sampleLight(frameLight(frame, i), v.s.position);
      vec3 sent = reflectedLight(v, arriving, true);
      float share = maxChannel(sent);
      if (!takesCandidate(c.pick, c.total, share * range.count)) continue;
      c.light = sent;
      c.arriving = arriving.intensity * arriving.attenuation;
      c.toLight = arriving.toLight;
      c.index = i;
      c.weight = share;
    }
  } while (lanesGoOn(++i < range.end));
}

// Returns the siblings of a group in the light tree whose boxes contain the point, as bits.
uint boxesAround(FrameConstants frame, uint group, vec3 point) {
  uint around = 0u;
  for (uint i = 0u; i < kLightTreeWidth; ++i) {
    LightBox box = frameLightBox(frame, group * kLightTreeWidth + i);
    bool inside = all(lessThanEqual(box.low, point)) && all(lessThanEqual(point, box.high));
    around |= inside ? 1u << i : 0u;
  }
  return around;
}

// Returns the lights of a leaf that is chosen by `u`, which is in [0, 1).
CandidateRange leafRange(FrameConstants frame, uint roots, vec3 point, float u) {
  CandidateRange range = CandidateRange(0u, 0u, 1.0 / float(kLeavesPerChoice));
  uint around = roots, group = 0u;
  while (around != 0u) {
    uint count = uint(bitCount(around)), skipped = min(uint(u * float(count)), count - 1u);
    u = clamp(u * float(count) - float(skipped), 0.0, 0.999999);
    range.count *= float(count);
    for (uint i = 0u; i < skipped; ++i) around &= around - 1u;
    uint node = group * kLightTreeWidth + uint(findLSB(around));
    group = node + 1u;
    around = node < frame.lightTreeLeaves ? boxesAround(frame, group, point) : 0u;
    if (node < frame.lightTreeLeaves) continue;
    range.first = frame.directionalLights + (node - frame.lightTreeLeaves) * kLightTreeWidth;
    range.end = min(range.first + kLightTreeWidth, frame.lightCount);
  }
  return range;
}

// Returns one of up to kMaxCandidates directional lights, which the tree does not contain.
CandidateRange directionalRange(FrameConstants frame, uint index, uint candidates, float u) {
  uint count = frame.directionalLights, start = count <= kMaxCandidates ? 0u : min(uint(u * float(count)), count - 1u);
  float stride = float(count) / float(candidates);
  uint light = (start + uint(float(index) * stride)) % count;
  return CandidateRange(light, light + 1u, stride);
}

LightChoice chooseLight(FrameConstants frame, PathVertex v, vec2 u) {
  LightChoice c = LightChoice(vec3(0.0), vec3(0.0), vec3(0.0), 0u, u.y, 0.0, 1.0);
  if (kLights == 0u || frame.lightCount == 0u) return c;
  bool all = frame.lightCount <= kMaxCandidates;
  uint directional = min(frame.directionalLights, kMaxCandidates), ranges = all ? 1u : directional + kLeavesPerChoice;
  uint roots = all ? 0u : boxesAround(frame, 0u, v.s.position);
  uint i = 0u;
  do {
    CandidateRange range = CandidateRange(0u, frame.lightCount, 1.0);
    if (!all && i < directional) range = directionalRange(frame, i, directional, u.x);
    if (!all && i >= directional)
      range = leafRange(frame, roots, v.s.position, (float(i - directional) + u.x) / float(kLeavesPerChoice));
    addCandidates(c, frame, v, range);
  } while (++i < ranges);
  c.light *= c.total / c.weight;
  c.arriving *= c.total / c.weight;
  return c;
}

#endif
