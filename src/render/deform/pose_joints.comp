#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the joint matrices of the skinned meshes of all worlds. A listed joint has the transform that the world gives
// it, times its inverse bind matrix; the others have the scene's matrices. The host's counterpart is
// scene::jointMatrices(). Each invocation handles one joint of a mesh in one world at one time.
#include "render/gpu_scene/world_inputs.glsl"
#include "render/deform/world_deform_push.h"

layout(local_size_x = kPlaceGroup) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer JobRef { JointJob v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer JointsRef { PosedJoint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer MatrixRef { mat4x3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer MatrixOut { mat4x3 v[]; };

layout(push_constant, scalar) uniform Push { WorldDeformPush push; };

// The array of a time that is not given is that of the current frame.
WorldNumbers givenAt(JointJob job, uint slot) {
  uint time = timeOfSlot(slot, job.slots);
  if (job.given[time].address == 0ul) time = 0u;
  return job.given[time];
}

// Returns kWorld* bits.
uint checkedJoint(WorldNumbers n, uint index, dmat4 toFile) {
  for (uint i = 0u; i < n.rows * 4u; ++i)
    if (!isFiniteFloat(numberAt(n, index * n.rows * 4u + i))) return kWorldNotFinite;
  return isAffine(toFile) ? 0u : kWorldWrongJoint;
}

mat4x3 jointMatrix(JointJob job, PosedJoint joint, uint index, dmat4 toFile) {
  dmat4 relative = dmat4(1.0);
  for (uint axis = 0u; axis < 3u; ++axis) relative[3][axis] = -DoublesRef(job.origins).v[3u * index + axis];
  dmat4 m = product(product(relative, toFile), dmat4(joint.inverseBind));
  return mat4x3(vec3(m[0].xyz), vec3(m[1].xyz), vec3(m[2].xyz), vec3(m[3].xyz));
}

void main() {
  JointJob job = JobRef(push.job).v;
  uint world = elementIndex() / job.jointCount, index = elementIndex() % job.jointCount, slot = gl_GlobalInvocationID.y;
  if (world >= job.worlds) return;
  PosedJoint joint = JointsRef(job.joints).v[index];
  uint inWorld = job.slots * joint.first + slot * joint.count + index - joint.first;
  MatrixOut result = MatrixOut(job.palettes + uint64_t(world) * job.slots * job.jointCount * 48ul);
  if (joint.listed == kNowhere) {
    result.v[inWorld] = MatrixRef(job.scene).v[inWorld];
    return;
  }
  WorldNumbers given = givenAt(job, slot);
  uint at = world * job.listed + joint.listed;
  dmat4 toFile = givenMatrix(given, at);
  uint bits = job.status == 0ul ? 0u : checkedJoint(given, at, toFile);
  if (bits != 0u) atomicOr(StatusRef(job.status).v[world], bits);
  result.v[inWorld] = jointMatrix(job, joint, index, toFile);
}
