#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the vertices of a mesh whose positions worlds give: the positions at each time, and the attributes of the
// current frame. Normals and tangents are those of the triangles around each vertex; the host's counterpart is
// scene::movedAttributes(). Each invocation handles one vertex in one world at one time.
#include "render/gpu_scene/world_inputs.glsl"
#include "render/deform/world_deform_push.h"

layout(local_size_x = kPlaceGroup) in;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer JobRef { VertexJob v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FanTriangles { DeviceFanTriangle v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer PositionsOut { VertexPosition v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer AttributesOut { VertexAttributes v[]; };

layout(push_constant, scalar) uniform Push { WorldDeformPush push; };

vec3 givenPosition(VertexJob job, WorldNumbers given, uint world, uint vertex) {
  uint at = 3u * (world * job.total + job.first + vertex);
  return vec3(numberAt(given, at), numberAt(given, at + 1u), numberAt(given, at + 2u));
}

dvec3 edge(vec3 from, vec3 to) {
  precise dvec3 d = widened(to) - widened(from);
  return d;
}

dvec3 addedCross(dvec3 sum, dvec3 a, dvec3 b) {
  precise dvec3 result = sum + dvec3(a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y);
  return result;
}

dvec3 addedAlong(dvec3 sum, dvec3 b, float alongB, dvec3 c, float alongC) {
  precise dvec3 result = sum + (b * double(alongB) + c * double(alongC));
  return result;
}

dvec3 withoutPart(dvec3 v, dvec3 normal, double part) {
  precise dvec3 result = v - normal * part;
  return result;
}

// Returns the vector with the length 1, or `otherwise` if it has no direction.
vec3 unitOr(dvec3 v, vec3 otherwise) {
  double squared = dotOf(v, v);
  if (!(squared > 0.0lf) || isinf(squared)) return otherwise;
  precise dvec3 unit = v / sqrt(squared);
  return vec3(unit);
}

VertexAttributes movedAttributes(VertexJob job, uint world, uint vertex) {
  VertexAttributes attributes = attributesAt(job.attributes, vertex);
  dvec3 normal = dvec3(0.0lf), tangent = dvec3(0.0lf);
  uint end = UintRef(job.fans).v[vertex + 1u];
  for (uint i = UintRef(job.fans).v[vertex]; i < end; ++i) {
    DeviceFanTriangle fan = FanTriangles(job.fanTriangles).v[i];
    uint corner = 3u * fan.triangle;
    vec3 a = givenPosition(job, job.given[0], world, UintRef(job.indices).v[corner]);
    dvec3 b = edge(a, givenPosition(job, job.given[0], world, UintRef(job.indices).v[corner + 1u]));
    dvec3 c = edge(a, givenPosition(job, job.given[0], world, UintRef(job.indices).v[corner + 2u]));
    normal = addedCross(normal, b, c);
    tangent = addedAlong(tangent, b, fan.alongB, c, fan.alongC);
  }
  attributes.normal = unitOr(normal, attributes.normal);
  dvec3 n = widened(attributes.normal);
  tangent = withoutPart(tangent, n, dotOf(n, tangent));
  attributes.tangent.xyz = unitOr(tangent, attributes.tangent.xyz);
  return attributes;
}

void main() {
  VertexJob job = JobRef(push.job).v;
  uint world = elementIndex() / job.vertices, vertex = elementIndex() % job.vertices, slot = gl_GlobalInvocationID.y;
  if (world >= job.worlds) return;
  uint time = timeOfSlot(slot, job.slots);
  if (job.given[time].address == 0ul) time = 0u;
  vec3 position = givenPosition(job, job.given[time], world, vertex) - job.origin;
  uint64_t at = (uint64_t(world) * job.slots + slot) * job.vertices + vertex;
  PositionsOut(job.outPositions + at * kPositionBytes).v[0].position = position;
  if (slot != job.slots / 2u) return;
  uint64_t attributesAt = uint64_t(world) * job.vertices + vertex;
  AttributesOut(job.outAttributes + attributesAt * kAttributesBytes).v[0] = movedAttributes(job, world, vertex);
}
