#version 460
#extension GL_GOOGLE_include_directive : require
// Checks the arrays that describe worlds: one invocation per world and per listed instance or camera, whichever are
// more. It writes kWorld* bits to WorldJob::status.
#include "render/visibility/compute/place_worlds.glsl"

bool isFiniteFloat(double number) {
  float rounded = float(number);
  return !isnan(rounded) && !isinf(rounded);
}

bool areFinite(WorldNumbers n, uint index, uint count) {
  bool finite = true;
  for (uint i = 0u; i < count; ++i) finite = finite && isFiniteFloat(numberAt(n, index * count + i));
  return finite;
}

bool isAffine(dmat4 m) { return m[0].w == 0.0lf && m[1].w == 0.0lf && m[2].w == 0.0lf && m[3].w == 1.0lf; }

// A rotation and a translation, with the tolerance of internalCamera().
bool isRigid(dmat4 m) {
  for (uint i = 0u; i < 3u; ++i)
    for (uint j = 0u; j < 3u; ++j)
      if (abs(dotOf(m[i].xyz, m[j].xyz) - (i == j ? 1.0lf : 0.0lf)) > 1e-3lf) return false;
  return isAffine(m) && determinantOf(m) > 0.0lf;
}

uint checkedTransform(WorldNumbers n, uint index) {
  if (n.address == 0ul) return 0u;
  if (!areFinite(n, index, n.rows * 4u)) return kWorldNotFinite;
  return isAffine(givenMatrix(n, index)) ? 0u : kWorldWrongTransform;
}

uint checkedPose(WorldNumbers n, uint index) {
  if (n.address == 0ul) return 0u;
  if (!areFinite(n, index, n.rows * 4u)) return kWorldNotFinite;
  return isRigid(givenMatrix(n, index)) ? 0u : kWorldWrongPose;
}

uint checkedIntrinsics(WorldNumbers n, uint index) {
  if (n.address == 0ul) return 0u;
  if (!areFinite(n, index, 9u)) return kWorldNotFinite;
  double k[9];
  for (uint i = 0u; i < 9u; ++i) k[i] = numberAt(n, index * 9u + i);
  bool right = k[0] > 0.0lf && k[4] > 0.0lf && k[1] == 0.0lf && k[3] == 0.0lf;
  right = right && k[6] == 0.0lf && k[7] == 0.0lf && k[8] == 1.0lf;
  return right ? 0u : kWorldWrongIntrinsics;
}

void main() {
  WorldJob job = JobRef(push.job).v;
  uint each = max(max(job.listed, job.viewsPerWorld), 1u), world = elementIndex() / each, i = elementIndex() % each;
  if (world >= job.worlds) return;
  uint bits = 0u;
  if (i == 0u && job.emptyWorlds != 0ul && UintRef(job.emptyWorlds).v[world] != 0u) bits = kWorldNotFinite;
  for (uint time = 0u; time < 3u; ++time) {
    if (i < job.listed) bits |= checkedTransform(job.givenTransforms[time], world * job.listed + i);
    if (i < job.viewsPerWorld) bits |= checkedPose(job.givenPoses[time], world * job.viewsPerWorld + i);
  }
  if (i < job.viewsPerWorld) bits |= checkedIntrinsics(job.intrinsics, world * job.viewsPerWorld + i);
  if (bits != 0u) report(job, world, bits);
}
