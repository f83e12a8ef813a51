#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the View of one camera in one world, at one time (y): makeView() of the host, with the same operations.
#include "render/visibility/compute/place_worlds.glsl"
#include "render/gpu_scene/view_constants_push.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewsIn { View v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ViewsOut { View v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ValuesOut { WorldValues v[]; };

// The minors of rows r and s of the last three columns, in the order in which inverseOf() needs them.
dvec4 minors(dmat4 m, uint r, uint s) {
  precise double c = m[2][r] * m[3][s] - m[3][r] * m[2][s];
  precise double d = m[1][r] * m[3][s] - m[3][r] * m[1][s];
  precise double e = m[1][r] * m[2][s] - m[2][r] * m[1][s];
  return dvec4(c, c, d, e);
}

dvec4 rowOf(dmat4 m, uint row) { return dvec4(m[1][row], m[0][row], m[0][row], m[0][row]); }

// The inverse by cofactors.
dmat4 inverseOf(dmat4 m) {
  dvec4 a = minors(m, 2u, 3u), b = minors(m, 1u, 3u), c = minors(m, 1u, 2u);
  dvec4 d = minors(m, 0u, 3u), e = minors(m, 0u, 2u), f = minors(m, 0u, 1u);
  dvec4 x = rowOf(m, 0u), y = rowOf(m, 1u), z = rowOf(m, 2u), w = rowOf(m, 3u);
  precise dmat4 adjugate;
  adjugate[0] = (y * a - z * b + w * c) * dvec4(1.0, -1.0, 1.0, -1.0);
  adjugate[1] = (x * a - z * d + w * e) * dvec4(-1.0, 1.0, -1.0, 1.0);
  adjugate[2] = (x * b - y * d + w * f) * dvec4(1.0, -1.0, 1.0, -1.0);
  adjugate[3] = (x * c - y * e + z * f) * dvec4(-1.0, 1.0, -1.0, 1.0);
  precise dvec4 products = m[0] * dvec4(adjugate[0].x, adjugate[1].x, adjugate[2].x, adjugate[3].x);
  precise double determinant = (products.x + products.y) + (products.z + products.w);
  precise double reciprocal = 1.0lf / determinant;
  precise dmat4 result;
  for (uint i = 0u; i < 4u; ++i) result[i] = adjugate[i] * reciprocal;
  return result;
}

mat4x3 rounded(dmat4 m) { return mat4x3(vec3(m[0].xyz), vec3(m[1].xyz), vec3(m[2].xyz), vec3(m[3].xyz)); }

// The frame of the instance that a camera rides on: its transform without scale.
dmat4 frameOfRide(WorldJob job, uint world, uint instance, uint time) {
  dmat4 frame = worldTransform(job, world, instance, time);
  bool wrong = false;
  for (uint i = 0u; i < 3u; ++i) {
    double lengthOf = sqrt(dotOf(frame[i].xyz, frame[i].xyz));
    wrong = wrong || !(lengthOf > 0.0lf);
    precise dvec4 axis = frame[i] / lengthOf;
    frame[i] = axis;
  }
  if (wrong || !isRigid(frame)) report(job, world, kWorldWrongRide);
  return frame;
}

dmat4 poseOf(WorldJob job, uint world, uint camera, uint time) {
  dmat4 own = columnsAt(job.cameraPoses, camera);
  if (isInvalid(job, world)) return own;
  WorldNumbers given = job.givenPoses[time];
  if (given.address == 0ul) given = job.givenPoses[0];
  if (given.address != 0ul) {
    dmat4 inFile = givenMatrix(given, world * job.viewsPerWorld + camera);
    own = product(product(columnsAt(job.matrices, kWorldFromFile), inFile), columnsAt(job.matrices, kCameraFromOpenCv));
  }
  uint ride = job.rides != 0ul ? UintRef(job.rides).v[camera] : kNowhere;
  if (ride == kNowhere) return own;
  dmat4 relative = product(columnsAt(job.matrices, kFileFromWorld), own);
  return product(frameOfRide(job, world, ride, time), relative);
}

void setIntrinsics(WorldJob job, inout Projection p, uint index) {
  double fx = numberAt(job.intrinsics, index * 9u), fy = numberAt(job.intrinsics, index * 9u + 4u);
  double cx = numberAt(job.intrinsics, index * 9u + 2u), cy = numberAt(job.intrinsics, index * 9u + 5u);
  precise double h = 2.0lf * fx / double(job.width), v = 2.0lf * fy / double(job.height);
  precise double x = 2.0lf * cx / double(job.width) - 1.0lf, z = 1.0lf - 2.0lf * cy / double(job.height);
  p.H = float(h);
  p.V = float(v);
  p.X = float(x);
  p.Z = float(z);
}

// x: cosine, y: sine. Rounded to floats, they are those of the host's functions for floats. The argument is reduced
// to an eighth of a turn (Cody and Waite 1980, Software Manual for the Elementary Functions), for which the Taylor
// series is as precise as doubles.
dvec2 cosineAndSine(double x) {
  const double kHalfPi = 1.57079632679489655800lf, kHalfPiLow = 6.12323399573676603587e-17lf;
  double quarters = floor(x / kHalfPi + 0.5lf);
  precise double y = (x - quarters * kHalfPi) - quarters * kHalfPiLow;
  double square = y * y, cosine = 1.0lf, sine = y, even = 1.0lf, odd = y;
  for (int i = 2; i < 20; i += 2) {
    even *= -square / double(i * (i - 1));
    odd *= -square / double(i * (i + 1));
    cosine += even;
    sine += odd;
  }
  int quadrant = int(quarters - 4.0lf * floor(quarters / 4.0lf));
  if (quadrant == 1) return dvec2(-sine, cosine);
  if (quadrant == 2) return dvec2(-cosine, -sine);
  return quadrant == 3 ? dvec2(sine, -cosine) : dvec2(cosine, sine);
}

void setEnvironment(WorldJob job, uint world) {
  bool invalid = isInvalid(job, world);
  if (job.environmentIndex.address != 0ul) {
    double index = clamp(numberAt(job.environmentIndex, world), 0.0lf, double(job.environments - 1u));
    ValuesOut(job.values).v[world].environmentMap = UintRef(job.environmentMaps).v[uint(index)];
  }
  if (job.environmentIntensity.address != 0ul)
    ValuesOut(job.values).v[world].environmentIntensity =
        invalid ? 0.0 : float(numberAt(job.environmentIntensity, world));
  if (job.environmentRotation.address == 0ul) return;
  double degrees = invalid ? 0.0lf : numberAt(job.environmentRotation, world);
  precise double radiansOf = degrees * 3.14159265358979323846lf / 180.0lf;
  dvec2 direction = cosineAndSine(roundedToFloat(radiansOf));
  ValuesOut(job.values).v[world].environmentCos = float(direction.x);
  ValuesOut(job.values).v[world].environmentSin = float(direction.y);
}

void main() {
  WorldJob job = JobRef(push.job).v;
  uint index = elementIndex(), world = index / job.viewsPerWorld, camera = index % job.viewsPerWorld;
  uint time = gl_GlobalInvocationID.y;
  if (world >= job.worlds) return;
  if (camera == 0u && time == 0u) setEnvironment(job, world);
  View view = ViewsIn(job.cameras).v[camera];
  dmat4 pose = poseOf(job, world, camera, time);
  for (uint i = 0u; i < 3u; ++i) {
    precise double reciprocal = 1.0lf / sqrt(dotOf(pose[i].xyz, pose[i].xyz));
    precise dvec3 axis = pose[i].xyz * reciprocal;
    pose[i] = dvec4(axis, 0.0lf);
  }
  precise dvec3 eye = pose[3].xyz - columnsAt(job.matrices, kDeviceOrigin)[0].xyz;
  pose[3] = dvec4(eye, pose[3].w);
  view.viewToWorld = rounded(pose);
  view.worldToView = rounded(inverseOf(pose));
  view.eye = vec3(eye);
  precise dvec3 low = eye - widened(view.eye);
  view.eyeLow = vec3(low);
  view.world = world;
  if (job.intrinsics.address != 0ul && !isInvalid(job, world)) setIntrinsics(job, view.projection, index);
  ViewsOut(job.views[time]).v[index] = view;
}
