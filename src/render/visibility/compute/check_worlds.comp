#version 460
#extension GL_GOOGLE_include_directive : require
// Checks the arrays that describe worlds: as many invocations per world as it has listed instances, cameras or
// lights, the maximum of these numbers. It writes kWorld* bits to WorldJob::status.
#include "render/visibility/compute/place_worlds.glsl"
#include "shared/light.h"

bool areFinite(WorldNumbers n, uint index, uint count) {
  bool finite = true;
  for (uint i = 0u; i < count; ++i) finite = finite && isFiniteFloat(numberAt(n, index * count + i));
  return finite;
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

// Numbers from 0 to `most`.
uint checkedFactors(WorldNumbers n, uint index, uint count, float most) {
  if (n.address == 0ul) return 0u;
  if (!areFinite(n, index, count)) return kWorldNotFinite;
  bool right = true;
  for (uint i = 0u; i < count; ++i) {
    float number = float(numberAt(n, index * count + i));
    right = right && number >= 0.0 && number <= most;
  }
  return right ? 0u : kWorldWrongFactors;
}

uint checkedMaterial(WorldJob job, uint index) {
  const float kUnbounded = 3.402823466e38;
  return checkedFactors(job.baseColor, index, 4u, kUnbounded) | checkedFactors(job.emissive, index, 3u, kUnbounded) |
         checkedFactors(job.metallic, index, 1u, 1.0) | checkedFactors(job.roughness, index, 1u, 1.0);
}

uint checkedChoice(WorldJob job, uint index) {
  if (job.materialChoice.address == 0ul) return 0u;
  double choice = numberAt(job.materialChoice, index);
  return choice >= 0.0lf && choice < double(job.paletteSize) ? 0u : kWorldWrongChoice;
}

// Returns true unless the light is a point light, which has no direction. `listed`: among the lights of the arrays.
bool usesDirection(WorldJob job, uint listed) {
  for (uint i = 0u; i < job.lights; ++i) {
    LightTemplate t = LightTemplates(job.lightTemplates).v[i];
    if (t.listed == listed) return (t.state & kLightIsArea) != 0u || t.light[0].type != kLightPoint;
  }
  return true;
}

uint checkedLight(WorldJob job, uint index) {
  const float kUnbounded = 3.402823466e38;
  uint factors = checkedFactors(job.lightColor, index, 3u, kUnbounded) |
                 checkedFactors(job.lightIntensity, index, 1u, kUnbounded);
  uint bits = (factors & kWorldWrongFactors) != 0u ? kWorldWrongLight : 0u;
  bits |= factors & kWorldNotFinite;
  if (job.lightPosition.address != 0ul && !areFinite(job.lightPosition, index, 3u)) bits |= kWorldNotFinite;
  if (job.lightDirection.address == 0ul) return bits;
  if (!areFinite(job.lightDirection, index, 3u)) return bits | kWorldNotFinite;
  dvec3 direction;
  for (uint i = 0u; i < 3u; ++i) direction[i] = roundedToFloat(numberAt(job.lightDirection, 3u * index + i));
  bool wrong = dotOf(direction, direction) == 0.0lf && usesDirection(job, index % job.listedLights);
  return wrong ? bits | kWorldWrongDirection : bits;
}

uint checkedEnvironment(WorldJob job, uint world) {
  uint bits = 0u;
  if (job.environmentIndex.address != 0ul) {
    double index = numberAt(job.environmentIndex, world);
    if (!(index >= 0.0lf && index < double(job.environments))) bits = kWorldWrongEnvironmentIndex;
  }
  if (job.environmentRotation.address != 0ul && !areFinite(job.environmentRotation, world, 1u)) bits |= kWorldNotFinite;
  if (job.environmentIntensity.address == 0ul) return bits;
  if (!areFinite(job.environmentIntensity, world, 1u)) return bits | kWorldNotFinite;
  return numberAt(job.environmentIntensity, world) < 0.0lf ? bits | kWorldWrongEnvironment : bits;
}

void main() {
  WorldJob job = JobRef(push.job).v;
  uint each = max(max(job.listed, job.viewsPerWorld), max(job.listedLights, 1u));
  uint world = elementIndex() / each, i = elementIndex() % each;
  if (world >= job.worlds) return;
  uint bits = 0u;
  if (i == 0u && job.emptyWorlds != 0ul && UintRef(job.emptyWorlds).v[world] != 0u) bits = kWorldNotFinite;
  for (uint time = 0u; time < 3u; ++time) {
    if (i < job.listed) bits |= checkedTransform(job.givenTransforms[time], world * job.listed + i);
    if (i < job.viewsPerWorld) bits |= checkedPose(job.givenPoses[time], world * job.viewsPerWorld + i);
  }
  if (i < job.listed) bits |= checkedMaterial(job, world * job.listed + i) | checkedChoice(job, world * job.listed + i);
  if (i < job.listedLights) bits |= checkedLight(job, world * job.listedLights + i);
  if (i == 0u) bits |= checkedEnvironment(job, world);
  if (i < job.viewsPerWorld) bits |= checkedIntrinsics(job.intrinsics, world * job.viewsPerWorld + i);
  if (bits != 0u) report(job, world, bits);
}
