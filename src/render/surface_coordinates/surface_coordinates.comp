#version 460
#extension GL_GOOGLE_include_directive : require
// Coordinates on the visible surface at each pixel's center, from the triangle that is visible there. The ray through
// the pixel's center meets the triangle's plane at barycentric coordinates (Moeller and Trumbore 1997, Fast, Minimum
// Storage Ray/Triangle Intersection, JGT 2(1)), computed in double-float arithmetic, because they also stand for
// positions in the object, which users compare with models. They interpolate the object's vertices at rest and the
// vertices' tangent frames.
#include "render/glsl/common.glsl"
#include "render/glsl/pixel_ray.glsl"
#include "render/glsl/vertex_directions.glsl"
#include "render/surface_coordinates/surface_coordinates_push.h"
#include "render/visibility/vast_triangle.glsl"
#include "shared/object_frame.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(push_constant, scalar) uniform Push { SurfaceCoordinatesPush push; };
layout(set = 0, binding = 0) uniform usampler2DArray triangles;  // number of the instance, from 1; index of the triangle
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2DArray coordinates;

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer ObjectFrameRef { ObjectFrame v[]; };

// --- barycentric coordinates -----------------------------------------------------------------------------------------

Exact3 inverseOf(Exact3 v) {
  Exact3 inverse = exact(1.0 / v.hi);  // refined by one step of Newton's method
  return multiply(inverse, subtract(exact(vec3(2.0)), multiply(v, inverse)));
}

struct ExactRay {  // view space
  Exact3 origin, direction;
};

ExactRay exactRay(FrameConstants frame, View view, ivec2 pixel) {
  if (kLens != 0u) return ExactRay(exact(vec3(0.0)), exact(lensRay(frame, view, pixel).direction));
  Projection p = view.projection;
  vec3 size = vec3(view.size.x, 1.0, view.size.y);
  vec2 twice = 2.0 * vec2(pixel) + 1.0;
  vec3 centered = vec3(twice.x - view.size.x, 0.0, view.size.y - twice.y);  // NDC times the size
  Exact3 scaled = subtract(exact(centered), exactProduct(vec3(p.X, 0.0, p.Z), size));
  Exact3 place = multiply(scaled, inverseOf(exactProduct(vec3(p.H, 1.0, p.V), size)));
  if (p.kind != kPerspective) return ExactRay(place, exact(vec3(0.0, 1.0, 0.0)));
  place.hi.y = 1.0;
  return ExactRay(exact(vec3(0.0)), place);
}

// Snapping lets a triangle cover pixels slightly outside of it. The rays of pixels on an edge-on triangle may meet its
// plane anywhere.
Exact3 bounded(Exact3 weight) {
  float within = clamp(weight.hi.x, -1.0, 2.0);
  if (within == weight.hi.x) return weight;
  return exact(vec3(within == within ? within : 1.0 / 3.0));
}

VastWeights weightsOf(ExactRay ray, Exact3 a, Exact3 b, Exact3 c) {
  Exact3 ab = subtract(b, a), ac = subtract(c, a), from = subtract(ray.origin, a);
  Exact3 scale = exact(vec3(1.0 / max(max(length(ab.hi), length(ac.hi)), 1e-37)));
  ab = multiply(ab, scale);
  ac = multiply(ac, scale);
  from = multiply(from, scale);
  Exact3 across = crossOf(ray.direction, ac);
  Exact3 inverse = inverseOf(dotOf(ab, across));
  return VastWeights(bounded(multiply(dotOf(from, across), inverse)),
                     bounded(multiply(dotOf(ray.direction, crossOf(from, ab)), inverse)));
}

vec3 barycentricOf(VastWeights w) {
  Exact3 first = subtract(exact(vec3(1.0)), add(w.b, w.c));
  return vec3(rounded(first).x, rounded(w.b).x, rounded(w.c).x);
}

// --- object coordinates ----------------------------------------------------------------------------------------------

vec3 objectCoordinate(uint instance, uvec3 indices, VastWeights w) {
  ObjectFrame object = ObjectFrameRef(push.objectFrames).v[instance];
  vec3 corners[3];
  for (int i = 0; i < 3; ++i) corners[i] = positionAt(object.positions, indices[i]);
  vec3 vertex = attributeOf(w, corners[0], corners[1], corners[2]);
  if (push.coordinate == kCoordinateObject) return object.objectFromVertex * vec4(vertex, 1.0);
  vec3 fromCenter = mat3(object.objectFromVertex) * vertex + object.fromCenter;
  return clamp(fromCenter * object.inverseDiagonal + 0.5, 0.0, 1.0);
}

// --- curvature -------------------------------------------------------------------------------------------------------

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer CurvatureRef { vec2 v[]; };

// The curvatures of the vertices at rest, interpolated.
vec3 curvatureCoordinate(uint instance, uvec3 indices, vec3 weights) {
  CurvatureRef curvatures = CurvatureRef(ObjectFrameRef(push.objectFrames).v[instance].curvatures);
  vec2 curvature = vec2(0.0);
  for (int i = 0; i < 3; ++i) curvature += weights[i] * curvatures.v[indices[i]];
  return vec3(curvature, 0.0);
}

// --- tangent frame ---------------------------------------------------------------------------------------------------

vec3 unitOrZero(vec3 v) {
  float squared = dot(v, v);
  return squared > 1e-12 ? v * inversesqrt(squared) : vec3(0.0);
}

// Returns the direction in which u grows along the triangle, in world axes; w: the bitangent's sign. The bitangent of
// glTF points up in the texture's image, against v.
vec4 tangentFromUv(VertexDirections directions, vec3 edges[2], VertexAttributes a[3], vec3 normal) {
  vec2 first = a[1].uv0 - a[0].uv0, second = a[2].uv0 - a[0].uv0;
  float area = first.x * second.y - first.y * second.x;
  vec3 alongU = sign(area) * (directions.linear * (edges[0] * second.y - edges[1] * first.y));
  vec3 alongV = sign(area) * (directions.linear * (edges[1] * first.x - edges[0] * second.x));
  // The length of the edges and of their UV is arbitrary.
  alongU *= 1.0 / max(max(abs(alongU.x), max(abs(alongU.y), abs(alongU.z))), 1e-37);
  return vec4(alongU, dot(cross(normal, alongU), alongV) > 0.0 ? -1.0 : 1.0);
}

vec3 tangentCoordinate(Instance instance, Mesh mesh, uvec3 indices, vec3 weights) {
  VertexDirections directions = vertexDirections(instance);
  VertexAttributes a[3];
  vec3 normal = vec3(0.0);
  vec4 tangent = vec4(0.0);
  for (int i = 0; i < 3; ++i) {
    a[i] = attributesAt(mesh.attributes, indices[i]);
    normal += weights[i] * worldNormal(directions, a[i].normal);
    tangent += weights[i] * a[i].tangent;
  }
  vec3 corner = positionAt(mesh.positions, indices.x);
  vec3 edges[2];
  for (int i = 0; i < 2; ++i) edges[i] = positionAt(mesh.positions, indices[i + 1]) - corner;
  if (dot(normal, normal) < 1e-12) normal = directions.handedness * (directions.cofactor * cross(edges[0], edges[1]));
  vec3 n = unitOrZero(normal);
  vec4 world = worldTangent(directions, tangent);
  vec3 t = unitOrZero(world.xyz - n * dot(n, world.xyz));
  if (t == vec3(0.0)) {
    world = tangentFromUv(directions, edges, a, n);
    t = unitOrZero(world.xyz - n * dot(n, world.xyz));
  }
  return push.coordinate == kCoordinateTangent ? t : cross(n, t) * (world.w < 0.0 ? -1.0 : 1.0);
}

// --- scene flow ------------------------------------------------------------------------------------------------------

// Both positions are relative to the current eye, so that the difference does not depend on where the scene is.
vec3 flowCoordinate(FrameConstants frame, View view, uint instance, Mesh mesh, uvec3 indices, vec3 weights) {
  mat4x3 now = relativeToEye(frameInstance(frame, instance), view);
  mat4x3 next = relativeToEye(instanceAt(frame.nextInstances, instance), view);
  vec3 flow = vec3(0.0);
  for (int i = 0; i < 3; ++i)
    flow += weights[i] * (next * vec4(positionAt(mesh.nextPositions, indices[i]), 1.0) -
                          now * vec4(positionAt(mesh.positions, indices[i]), 1.0));
  return flow;
}

// ---------------------------------------------------------------------------------------------------------------------

vec3 coordinateAt(ivec3 pixel, uint instanceIndex, uint triangle) {
  FrameConstants frame = frameOf(push.frame, uint(pixel.z));
  View view = frameView(frame, uint(pixel.z));
  Instance instance = frameInstance(frame, instanceIndex);
  Mesh mesh = frameMesh(frame, instance.mesh);
  uvec3 indices = triangleIndices(mesh, triangle);
  Exact3 corners[3];
  for (int i = 0; i < 3; ++i) corners[i] = seenExactly(view, instance, positionAt(mesh.positions, indices[i]));
  VastWeights weights = weightsOf(exactRay(frame, view, pixel.xy), corners[0], corners[1], corners[2]);
  if (push.coordinate == kCoordinateBarycentric) return barycentricOf(weights);
  if (push.coordinate <= kCoordinateNocs) return objectCoordinate(instanceIndex, indices, weights);
  if (push.coordinate == kCoordinateCurvature)
    return curvatureCoordinate(instanceIndex, indices, barycentricOf(weights));
  if (push.coordinate == kCoordinateFlow)
    return flowCoordinate(frame, view, instanceIndex, mesh, indices, barycentricOf(weights));
  return tangentCoordinate(instance, mesh, indices, barycentricOf(weights));
}

void main() {
  ivec3 size = imageSize(coordinates), pixel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(pixel, size))) return;
  uvec2 visible = texelFetch(triangles, pixel, 0).xy;
  vec3 found = visible.x == 0u ? vec3(0.0) : coordinateAt(pixel, visible.x - 1u, visible.y);
  imageStore(coordinates, pixel, vec4(found, 0.0));
}
