// The vertex shader of scene draws. MOTION before the include: where the vertex was and will be besides. NO_VARYINGS:
// where it is, and nothing else.
#define VERTEX_STAGE
#include "render/glsl/common.glsl"
#include "render/glsl/vertex_directions.glsl"
#include "render/visibility/varyings.glsl"
#ifdef FRAGMENT_ORDER  // before the include: the place of the instance among those that are drawn
layout(location = 9) flat out uint varyingDrawn;
#endif
#ifdef MOTION
#include "render/visibility/motion_varyings.glsl"
#endif

// The geometry pass compares for equality with the depth that the depth pass left.
invariant gl_Position;

// What comes from vertex buffers (draw.cpp): lavapipe loads by address lane by lane, which cost four times as much as the
// rest of this shader. What is the same for all vertices of a draw is an element of an instance.
layout(location = 0) in vec3 inPosition;
#ifndef NO_VARYINGS
layout(location = 1) in vec3 inNormal;
layout(location = 2) in vec4 inTangent;
layout(location = 3) in vec2 inUv0;
#endif
layout(location = 4) in uint inInstance;  // as the scene numbers them
layout(location = 5) in vec3 inWorldToView[3];  // columns of the rotation
layout(location = 8) in vec3 inEye;
layout(location = 9) in vec4 inProjection;
layout(location = 10) in vec2 inPrincipal;
layout(location = 11) in uint inProjectionKind;
layout(location = 12) in vec3 inEyeLow;

// Returns the position relative to the eye.
vec3 placeVertex(Instance instance) {
  Projection projection = Projection(inProjection.x, inProjection.y, inProjection.z, inProjection.w, inPrincipal.x,
                                     inPrincipal.y, inProjectionKind);
  vec3 relative = relativeToEye(instance, inEye, inEyeLow) * vec4(inPosition, 1.0);
  gl_Position = projectToClip(projection, mat3(inWorldToView[0], inWorldToView[1], inWorldToView[2]) * relative);
  return relative;
}

#ifdef NO_VARYINGS
void main() { placeVertex(instanceAt(push.instances, inInstance)); }
#else
// By address on a GPU: for attributes of triangles that are culled, vertex buffers cost an H200 3 % of the geometry pass.
VertexAttributes vertexAttributes(Instance instance) {
  if (kCpuDevice != 0u) return VertexAttributes(inNormal, inTangent, inUv0, float[3](0.0, 0.0, 0.0));
  return attributesAt(frameMesh(FrameRef(push.frame).v, instance.mesh).attributes, gl_VertexIndex);
}

void main() {
  Instance instance = instanceAt(push.instances, inInstance);
  vec3 relative = placeVertex(instance);
  VertexAttributes attributes = vertexAttributes(instance);
  VertexDirections directions = vertexDirections(instance);
  varyingPosition = relative + inEye;
  varyingNormal = worldNormal(directions, attributes.normal);
  varyingTangent = worldTangent(directions, attributes.tangent);
  varyingUv = vec4(attributes.uv0, attributes.uv0);
  varyingColor = vec4(1.0);
  // A loop, since lavapipe runs a branch whether any lane takes it or not.
  for (bool some = (instance.flags & kInstanceExtras) != 0u; some; some = false) {
    VertexExtra extra = ExtraRef(frameMesh(FrameRef(push.frame).v, instance.mesh).extras).v[gl_VertexIndex];
    varyingUv.zw = extra.uv1;
    varyingColor = extra.color;
  }
  varyingInstance = inInstance;
#ifdef FRAGMENT_ORDER
  varyingDrawn = gl_InstanceIndex;
#endif
#ifdef MOTION
  FrameConstants frame = FrameRef(push.frame).v;
  passMotion(frame, frameView(frame, push.view), frameMesh(frame, instance.mesh), relative, inInstance);
#endif
}
#endif
