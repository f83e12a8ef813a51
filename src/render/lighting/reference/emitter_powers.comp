#version 460
#extension GL_GOOGLE_include_directive : require
// The power of each emissive triangle (RayScene::emitters), by which paths choose among them: the area times the mean
// emission, in the largest channel, of kPoints points that are spread evenly over the triangle. One invocation per
// triangle and, with worlds, view; output: push.sums.
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

const uint kPoints = 8u;

vec3 emittedBy(FrameConstants frame, uint material, SurfacePoint p) {
  Material m = frameMaterial(frame, material);
  fetchTexels(frame, material, p, 1u << kTextureBaseColor | 1u << kTextureEmissive);
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
  float power = 0.0;
  for (uint i = 0u; i < kPoints; ++i) {
    vec2 u = raySample(vec2(0.5), i);
    float side = sqrt(u.x);
    hit.weights = vec3(1.0 - side, side * (1.0 - u.y), side * u.y);
    SurfacePoint p = rayPoint(frame, ray, hit);
    power += maxChannel(emittedBy(frame, material, p)) * 0.5 * length(p.plane) / float(kPoints);
  }
  PowersRef(push.sums + uint64_t(gl_WorkGroupID.z) * push.stride * 4ul).v[index] = power;
}
