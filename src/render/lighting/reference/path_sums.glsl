// The sums over the samples of a pixel, and what the last pass writes of them.
#ifndef LATELIGHT_PATH_SUMS_GLSL
#define LATELIGHT_PATH_SUMS_GLSL
#include "render/lighting/reference/path_eye.glsl"
#include "render/lighting/reference/path_lobes.glsl"

layout(set = 0, binding = AFTER_LIT_MAPS + 1, rgba32f) uniform image2DArray pathSum;
layout(set = 0, binding = AFTER_LIT_MAPS + 2, rgba32f) uniform image2DArray mirroredSum;
layout(set = 0, binding = AFTER_LIT_MAPS + 3, rgba32ui) uniform writeonly uimage2DArray filterGuide;
layout(set = 0, binding = AFTER_LIT_MAPS + 4, rgba16f) uniform writeonly image2DArray scatteredAlbedo;
layout(set = 0, binding = AFTER_LIT_MAPS + 5, rgba16f) uniform writeonly image2DArray mirroredAlbedo;

vec3 lightsAt(FrameConstants frame, View view, LitPixel p) { return vec3(0.0); }

// Radiance toward the eye through both lobes of the visible surface; without kFiltered, `scattered` holds all of it.
struct PathLight {
  vec3 scattered, mirrored;
};

vec3 lobeShare(PathVertex v, vec3 toLight) { return kFiltered != 0u ? mirroredShare(v, toLight) : vec3(0.0); }

// The albedos by which light through the lobes of a surface is divided.
PathLight albedosOf(PathVertex v) { return PathLight(max(v.s.scattered, vec3(1e-3)), max(v.mirrored, vec3(1e-3))); }

// Returns the mean of the samples, and the variance of its luminance.
vec4 meanOf(vec4 sum) {
  float count = float(push.samples);
  vec3 mean = sum.rgb / count;
  float spread = max(sum.w / count - luminance(mean) * luminance(mean), 0.0);
  return vec4(mean, spread / max(count - 1.0, 1.0));
}

// The sums of a pixel's samples.
struct PathSums {
  vec4 scattered, mirrored;
};

// Adds a sample. `fromEye`: the path started at the eye, and `covers` states if it found a surface.
void addSample(inout PathSums sums, PathLight light, PathLight albedos, bool fromEye, bool covers) {
  vec3 scattered = light.scattered / albedos.scattered, mirrored = light.mirrored / albedos.mirrored;
  float square = luminance(scattered) * luminance(scattered);
  sums.scattered += vec4(scattered, fromEye ? (covers ? 1.0 : 0.0) : square);
  sums.mirrored += vec4(mirrored, luminance(mirrored) * luminance(mirrored));
}

// Returns the sums of earlier passes.
PathSums earlierSums(ivec3 place) {
  PathSums sums = PathSums(vec4(0.0), vec4(0.0));
  if (push.first > 0u) sums.scattered = imageLoad(pathSum, place);
  if (push.first > 0u && kFiltered != 0u) sums.mirrored = imageLoad(mirroredSum, place);
  return sums;
}

// Writes the inputs of the filter, and takes the light that it replaces out of the picture. Light along paths from the
// eye is filtered as the reflection of a smooth surface.
void writeForFilter(FrameConstants frame, ivec3 place, LitPixel p, PathLight albedos, PathSums sums, EyeRay eye,
                    bool lit) {
  float covered = sums.scattered.a / float(push.samples);
  if (eye.starts) sums.scattered = vec4(0.0);
  imageStore(pathSum, place, meanOf(sums.scattered));
  imageStore(mirroredSum, place, meanOf(sums.mirrored));
  uint normal = packSnorm2x16(octahedralFromDirection(eye.starts ? -eye.ray.direction : p.s.normal));
  vec3 position = eye.starts ? eye.position : p.s.position;
  bool filtered = lit || eye.starts;
  imageStore(filterGuide, place, filtered ? uvec4(floatBitsToUint(position), normal) : uvec4(0u));
  imageStore(scatteredAlbedo, place, vec4(albedos.scattered, eye.starts ? 0.05 : p.s.roughness));
  imageStore(mirroredAlbedo, place, vec4(albedos.mirrored, filtered ? 1.0 : 0.0));
  if (eye.starts)
    imageStore(lightTarget, place, vec4(vec3(0.0), covered));
  else if (lit)
    imageStore(lightTarget, place, imageLoad(lightTarget, place) - vec4(p.radiance * frame.exposure, 0.0));
}

void writeLight(FrameConstants frame, ivec3 place, LitPixel p, vec4 sum, EyeRay eye, bool lit) {
  vec4 mean = sum / float(push.samples);
  vec4 light = vec4(0.0);
  if (eye.starts)
    light = vec4(min(mean.rgb * frame.exposure, vec3(65504.0)), mean.a);
  else if ((kPathFlags & kPathsFromLights) != 0u)
    light = p.lit ? vec4(min(p.emitted + mean.rgb * frame.exposure, vec3(65504.0)), 1.0) : vec4(0.0);
  else
    light = imageLoad(lightTarget, place) + vec4(lit ? (mean.rgb - p.radiance) * frame.exposure : vec3(0.0), 0.0);
  imageStore(lightTarget, place, clamp(light, vec4(0.0), vec4(vec3(65504.0), 1.0)));
}

// Stores the sums for the next pass, or, after the last sample, writes the picture or the inputs of the filter.
void writeSums(FrameConstants frame, ivec3 place, LitPixel p, PathLight albedos, PathSums sums, EyeRay eye, bool lit) {
  if (push.end < push.samples) {
    imageStore(pathSum, place, sums.scattered);
    if (kFiltered != 0u) imageStore(mirroredSum, place, sums.mirrored);
  } else if (kFiltered != 0u) {
    writeForFilter(frame, place, p, albedos, sums, eye, lit);
  } else {
    writeLight(frame, place, p, sums.scattered, eye, lit);
  }
}

#endif
