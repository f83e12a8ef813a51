// One of a scene's lights per sample, for rays: chosen among up to kCandidates lights by what each would add without
// shadows (Talbot, Cline and Egbert 2005, Importance Resampling for Global Illumination).
#ifndef LATELIGHT_LIGHT_CHOICE_GLSL
#define LATELIGHT_LIGHT_CHOICE_GLSL
#include "render/glsl/ray_samples.glsl"
#include "render/glsl/rays.glsl"
#include "render/glsl/setup.glsl"
#include "shared/light.h"
#include "shared/shade.h"

struct LightChoice {
  vec3 light;  // what the surface reflects of all lights, estimated by the chosen one, if nothing blocks it; 0: none
  vec3 toLight;
  float far;  // meters to the light
  uint index;
};

LightChoice chooseLight(FrameConstants frame, Surface s, SurfaceBrdf brdf, uint shading, vec2 u) {
  const uint kCandidates = 32u;
  LightChoice choice = LightChoice(vec3(0.0), vec3(0.0), 0.0, 0u);
  uint count = frame.lightCount, candidates = min(count, kCandidates);
  if (kLights == 0u || count == 0u) return choice;
  uint start = min(uint(u.x * float(count)), count - 1u);
  float stride = float(count) / float(candidates), total = 0.0, pick = u.y, weight = 1.0;
  for (uint i = 0u; i < candidates; ++i) {
    uint candidate = (start + uint(float(i) * stride)) % count;
    Light light = frameLight(frame, candidate);
    LightSample arriving = sampleLight(light, s.position);
    vec3 sent = dot(s.geonormal, arriving.toLight) > 0.0 ? shadeLight(brdf, arriving, shading) : vec3(0.0);
    float share = maxChannel(sent);
    total += share;
    bool taken = share > 0.0 && pick * total < share;
    float kept = share / max(total, 1e-30);
    pick = clamp(taken ? pick / kept : (pick - kept) / max(1.0 - kept, 1e-6), 0.0, 0.999999);
    if (!taken) continue;
    choice.light = sent;
    choice.index = candidate;
    weight = share;
    choice.toLight = arriving.toLight;
    choice.far = lightIsDirectional(light.type) ? 3.0e38 : length(light.position - s.position);
  }
  choice.light *= total / weight * stride;
  return choice;
}

// Returns a ray from a surface at a distance from the eye, or from the previous point of a path.
Ray surfaceRay(Surface s, float distance, vec3 direction, float far) {
  return Ray(s.position + s.geonormal * rayOffset(s.position, distance), vec3(0.0), direction, 0.0, far);
}

bool isShadowed(FrameConstants frame, Surface s, float distance, LightChoice choice) {
  return isBlocked(frame, surfaceRay(s, distance, choice.toLight, choice.far * (1.0 - 1e-5)));
}

#endif
