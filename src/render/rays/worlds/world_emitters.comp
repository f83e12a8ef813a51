#version 460
#extension GL_GOOGLE_include_directive : require
// Lists the emissive triangles of each world, one workgroup per world: those of the instances that the world has, with
// materials that may emit light there, in the order of WorldBvhJob::scene, which lists the triangles of all candidates.
// Runs after world_instances.comp. The host's counterpart for scenes without worlds is emittersOf().
#include "render/rays/worlds/world_bvh.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer EmittersRef { RayEmitter v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer EmittersOut { RayEmitter v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer IndicesOut { uint v[]; };

bool emits(WorldBvhJob job, Instance instance) {
  if ((instance.flags & kInstanceAbsent) != 0u) return false;
  Material m = MaterialRef(job.materials + uint64_t(instance.material) * kMaterialBytes).v;
  if (translucent(m.flags)) return false;  // rays pass it
  return (m.flags & kMaterialUnlit) != 0u || any(greaterThan(m.emissive, vec3(0.0)));
}

// Returns the first emitter of the next candidate, or the number of all.
uint nextCandidate(WorldBvhJob job, uint instance) {
  for (uint i = instance + 1u; i < job.instanceCount; ++i) {
    uint first = UintRef(job.scene.emitterIndices).v[i];
    if (first != kRayNone) return first;
  }
  return job.scene.emitterCount;
}

void main() {
  WorldBvhJob job = JobRef(push.job).v;
  for (uint world = gl_WorkGroupID.x; world < job.worlds; world += gl_NumWorkGroups.x) {
    uint64_t first = uint64_t(world) * job.instanceCount, instances = job.instances + first * kInstanceBytes;
    uint64_t emitters = job.emitters + uint64_t(world) * job.scene.emitterCount * 16ul;
    uint64_t indices = job.emitterIndices + first * 4ul;
    uint count = 0u;
    for (uint i = 0u; i < job.instanceCount; ++i) {
      uint candidate = UintRef(job.scene.emitterIndices).v[i];
      bool some = candidate != kRayNone && emits(job, InstancesRef(instances).v[i]);
      if (gl_LocalInvocationID.x == 0u) IndicesOut(indices).v[i] = some ? count : kRayNone;
      if (!some) continue;
      uint triangles = nextCandidate(job, i) - candidate;
      for (uint k = gl_LocalInvocationID.x; k < triangles; k += kWorldBvhGroup)
        EmittersOut(emitters).v[count + k] = EmittersRef(job.scene.emitters).v[candidate + k];
      count += triangles;
    }
    if (gl_LocalInvocationID.x > 0u) continue;
    ScenesRef(job.scenes).v[world].emitters = emitters;
    ScenesRef(job.scenes).v[world].emitterIndices = indices;
    ScenesRef(job.scenes).v[world].emitterCount = count;
  }
}
