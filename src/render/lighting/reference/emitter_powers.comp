#version 460
#extension GL_GOOGLE_include_directive : require
// The power of each emissive triangle (RayScene::emitters), by which paths choose among them: the area times the mean
// emission, in the largest channel, of kPoints points that are spread evenly over the triangle. Textures are sampled
// from coarse levels, so that together, the points see every texel of the triangle: if a small bright spot lay between
// them, paths would never choose the triangle. One invocation per triangle and, with worlds, view; output: push.sums.
#define LOADS_TEXELS
#include "render/glsl/common.glsl"
#include "render/glsl/ray_point.glsl"
#include "render/glsl/ray_samples.glsl"
#include "render/glsl/surface.glsl"
#include "render/lighting/reference/emitters_push.h"
#include "shared/color.h"

layout(local_size_x = 64) in;

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PowersRef { float v[]; };

layout(push_constant, scalar) uniform Push { EmittersPush push; };

const uint kPoints = 16u;

// Fetches texels from the level at which a texel covers an eighth to a quarter of the triangle's longest edge, as
// bilinear filtering does even if the sampler selects the nearest texel. `corners`: the triangle's texture coordinates.
void fetchCoarseTexels(FrameConstants frame, uint material, SurfacePoint p, vec4 corners[3]) {
  uint64_t at = frame.materials + uint64_t(material) * kMaterialBytes;
  uint left = sceneWordAt(at, kMaterialTexturesAt) & (1u << kTextureBaseColor | 1u << kTextureEmissive);
  do {
    if (left != 0u) {
      uint slot = uint(findLSB(left));
      TextureTransform transform = textureTransform(at, slot);
      TextureRecord texture = textureAt(frame.textures, sceneWordAt(at, kMaterialImagesAt + slot));
      vec2 uv[3];
      for (int i = 0; i < 3; ++i) uv[i] = transformedUv(transform, corners[i]) * vec2(texture.width, texture.height);
      float longest = max(max(distance(uv[0], uv[1]), distance(uv[1], uv[2])), distance(uv[2], uv[0]));
      uint level = min(uint(ceil(log2(max(0.125 * longest, 1.0)))), texture.levels - 1u);
      rayTexels[slot] = filteredLevel(texture, levelOf(texture, level), transformedUv(transform, p.uv), false);
      left &= left - 1u;
    }
  } while (lanesGoOn(left != 0u));
}

vec3 emittedBy(Material m, SurfacePoint p) {
  if ((m.flags & kMaterialUnlit) != 0u) return baseColor(m, p).rgb;
  vec3 emitted = m.emissive;
  if (hasTexture(m, kTextureEmissive)) emitted *= sampleTexture(m, kTextureEmissive, p).rgb;
  return emitted;
}

void main() {
  uint index = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x);
  FrameConstants frame = frameOf(push.frame, gl_WorkGroupID.z);
  RayScene scene = loadRayScene(frame.rayScene);
  if (index >= scene.emitterCount) return;
  RayEmitter emitter = sceneEmitter(scene, index);
  uint material = frameInstance(frame, emitter.instance).material;
  Ray ray = Ray(frameInstance(frame, emitter.instance).objectToWorld[3], vec3(0.0), vec3(0.0), 0.0, 0.0);
  RayHit hit = noHit();
  hit.instance = emitter.instance;
  hit.corners = uvec3(emitter.corners[0], emitter.corners[1], emitter.corners[2]);
  hit.front = true;
  vec4 corners[3];
  for (uint i = 0u; i < 3u; ++i) {
    hit.weights = vec3(0.0);
    hit.weights[i] = 1.0;
    corners[i] = rayPoint(frame, ray, hit).uv;
  }
  Material m = frameMaterial(frame, material);
  float power = 0.0;
  for (uint i = 0u; i < kPoints; ++i) {
    vec2 u = raySample(vec2(0.5), i);
    float side = sqrt(u.x);
    hit.weights = vec3(1.0 - side, side * (1.0 - u.y), side * u.y);
    SurfacePoint p = rayPoint(frame, ray, hit);
    fetchCoarseTexels(frame, material, p, corners);
    power += maxChannel(emittedBy(m, p)) * 0.5 * length(p.plane) / float(kPoints);
  }
  PowersRef(push.sums + uint64_t(gl_WorkGroupID.z) * push.stride * 4ul).v[index] = power;
}
