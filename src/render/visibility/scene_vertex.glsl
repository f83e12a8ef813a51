// The vertex shader of scene draws. Options, defined before the include: MOTION adds the vertex's clip positions in the
// previous and next frame, NO_VARYINGS outputs only gl_Position, INSTANCE_VARYING adds the instance to it, and
// FRAGMENT_ORDER adds the instance's position in the draw order.
#define VERTEX_STAGE
#include "render/glsl/common.glsl"
#include "render/glsl/vertex_directions.glsl"
#include "render/visibility/varyings.glsl"
#include "render/visibility/vast_triangle.glsl"
#ifdef FRAGMENT_ORDER  // the instance's index in DeviceDraws::instances()
layout(location = 9) flat out uint varyingDrawn;
#endif
#ifdef MOTION
#include "render/visibility/motion_varyings.glsl"
#endif

// The geometry pass tests for equality with the depth of the depth pass.
invariant gl_Position;

// Inputs from vertex buffers (draw.cpp), because lavapipe loads by address lane by lane, which is slower than the rest
// of this shader. Values that are the same for all vertices of a draw are instance-rate attributes.
layout(location = 0) in vec3 inPosition;
#ifndef NO_VARYINGS
layout(location = 1) in vec3 inNormal;
layout(location = 2) in vec4 inTangent;
layout(location = 3) in vec2 inUv0;
#endif
layout(location = 4) in uint inInstance;  // index in the scene
layout(location = 5) in vec3 inWorldToView[3];  // columns of the rotation
layout(location = 8) in vec3 inEye;
layout(location = 9) in vec4 inProjection;
layout(location = 10) in vec2 inPrincipal;
layout(location = 11) in uint inProjectionKind;
layout(location = 12) in vec3 inEyeLow;

View drawnView() {
  View view;
  view.projection = Projection(inProjection.x, inProjection.y, inProjection.z, inProjection.w, inPrincipal.x, inPrincipal.y,
                               inProjectionKind);
  view.worldToView = mat4x3(inWorldToView[0], inWorldToView[1], inWorldToView[2], vec3(0.0));
  view.eye = inEye;
  view.eyeLow = inEyeLow;
  return view;
}

// Sets gl_Position. Returns the position relative to the eye, in world axes.
vec3 placeVertex(Instance instance) {
  View view = drawnView();
  vec3 relative = relativeToEye(instance, inEye, inEyeLow) * vec4(inPosition, 1.0);
  gl_Position = projectToClip(view.projection, toView(view, relative));
  return relative;
}

// --- vast triangles --------------------------------------------------------------------------------------------------
//
// The graphics pipeline clips in single precision, which is too late for vast triangles. Each vertex therefore clips
// its whole triangle and outputs one corner of a fan of kVastFan triangles that cover the remaining polygon.

struct VastVertex {
  uvec3 indices;
  VastWeights weights;
  vec3 relative;  // relative to the eye, in world axes
};

VastVertex placeVastVertex(Instance instance, Mesh mesh) {
  uint inTriangle = gl_VertexIndex % (3u * kVastFan), fan = inTriangle / 3u, corner = inTriangle % 3u;
  View view = drawnView();
  VastVertex vertex;
  vertex.indices = triangleIndices(mesh, gl_VertexIndex / (3u * kVastFan));
  Exact3 corners[3];
  for (int i = 0; i < 3; ++i) corners[i] = seenExactly(view, instance, positionAt(mesh.positions, vertex.indices[i]));
  VastPolygon polygon = clipVast(view, corners);
  uint place = corner == 0u || fan + 2u >= polygon.count ? 0u : fan + corner;
  vec3 seen = polygon.count == 0u ? vec3(0.0) : rounded(polygon.corners[place]);
  gl_Position = polygon.count == 0u ? vec4(0.0) : projectToClip(view.projection, seen);
  vertex.weights = vastWeights(corners[0], corners[1], corners[2], exact(seen));
  vertex.relative = toWorldAxes(view, seen);
  return vertex;
}

#ifdef NO_VARYINGS
void main() {
  Instance instance = instanceAt(push.instances, inInstance);
#ifdef INSTANCE_VARYING
  varyingInstance = inInstance;
#endif
  if (kVastDraw != 0u)
    placeVastVertex(instance, frameMesh(FrameRef(push.frame).v, instance.mesh));
  else
    placeVertex(instance);
}
#else
// GPUs load attributes by address: vertex buffers would also fetch the attributes of culled triangles.
VertexAttributes vertexAttributes(Instance instance) {
  if (kCpuDevice != 0u) return VertexAttributes(inNormal, inTangent, inUv0, float[3](0.0, 0.0, 0.0));
  return attributesAt(frameMesh(FrameRef(push.frame).v, instance.mesh).attributes, gl_VertexIndex);
}

void setVastVaryings(Instance instance, Mesh mesh, VastVertex vertex) {
  VertexDirections directions = vertexDirections(instance);
  VertexAttributes corners[3];
  for (int i = 0; i < 3; ++i) corners[i] = attributesAt(mesh.attributes, vertex.indices[i]);
  vec3 weights = vec3(0.0, rounded(vertex.weights.b).x, rounded(vertex.weights.c).x);
  weights.x = 1.0 - weights.y - weights.z;
  varyingNormal = vec3(0.0);
  varyingTangent = vec4(0.0);
  for (int i = 0; i < 3; ++i) {
    varyingNormal += weights[i] * worldNormal(directions, corners[i].normal);
    varyingTangent += weights[i] * worldTangent(directions, corners[i].tangent);
  }
  varyingUv.xy = attributeOf(vertex.weights, vec3(corners[0].uv0, 0.0), vec3(corners[1].uv0, 0.0), vec3(corners[2].uv0, 0.0)).xy;
  varyingUv.zw = varyingUv.xy;
  varyingColor = vec4(1.0);
  if ((instance.flags & kInstanceExtras) == 0u) return;
  VertexExtra extras[3];
  for (int i = 0; i < 3; ++i) extras[i] = ExtraRef(mesh.extras).v[vertex.indices[i]];
  varyingUv.zw = attributeOf(vertex.weights, vec3(extras[0].uv1, 0.0), vec3(extras[1].uv1, 0.0), vec3(extras[2].uv1, 0.0)).xy;
  varyingColor = weights.x * extras[0].color + weights.y * extras[1].color + weights.z * extras[2].color;
}

uvec4 drawNumbers(Instance instance) {
  return uvec4(instance.id, instance.part, instance.mesh, floatBitsToUint(FrameRef(push.frame).v.exposure));
}

void vastMain(Instance instance) {
  FrameConstants frame = FrameRef(push.frame).v;
  Mesh mesh = frameMesh(frame, instance.mesh);
  VastVertex vertex = placeVastVertex(instance, mesh);
  setVastVaryings(instance, mesh, vertex);
  varyingPosition = vec4(vertex.relative + inEye, 1.0);
  varyingInstance = inInstance;
  varyingNumbers = drawNumbers(instance);
#ifdef FRAGMENT_ORDER
  varyingDrawn = gl_InstanceIndex;
#endif
#ifdef MOTION
  passVastMotion(frame, frameView(frame, push.view), vertex.relative);
#endif
}

void main() {
  Instance instance = instanceAt(push.instances, inInstance);
  if (kVastDraw != 0u) {
    vastMain(instance);
    return;
  }
  vec3 relative = placeVertex(instance);
  VertexAttributes attributes = vertexAttributes(instance);
  VertexDirections directions = vertexDirections(instance);
  varyingPosition = vec4(relative + inEye, 1.0);
  varyingNormal = worldNormal(directions, attributes.normal);
  varyingTangent = worldTangent(directions, attributes.tangent);
  varyingUv = vec4(attributes.uv0, attributes.uv0);
  varyingColor = vec4(1.0);
  if ((instance.flags & kInstanceExtras) != 0u) {
    VertexExtra extra = ExtraRef(frameMesh(FrameRef(push.frame).v, instance.mesh).extras).v[gl_VertexIndex];
    varyingUv.zw = extra.uv1;
    varyingColor = extra.color;
  }
  varyingInstance = inInstance;
  varyingNumbers = drawNumbers(instance);
#ifdef FRAGMENT_ORDER
  varyingDrawn = gl_InstanceIndex;
#endif
#ifdef MOTION
  FrameConstants frame = FrameRef(push.frame).v;
  passMotion(frame, frameView(frame, push.view), frameMesh(frame, instance.mesh), relative, inInstance);
#endif
}
#endif
