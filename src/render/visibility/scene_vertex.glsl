// The vertex shader of scene draws. MOTION before the include: where the vertex was and will be besides.
#define VERTEX_STAGE
#include "render/glsl/common.glsl"
#include "render/visibility/varyings.glsl"
#ifdef FRAGMENT_ORDER  // before the include: the place of the instance among those that are drawn
layout(location = 9) flat out uint varyingDrawn;
#endif
#ifdef MOTION
#include "render/visibility/motion_varyings.glsl"
#endif

// The geometry pass compares for equality with the depth that the depth pass left.
invariant gl_Position;

void main() {
  FrameConstants frame = FrameRef(push.frame).v;
  uint index = UintRef(push.instances).v[gl_InstanceIndex];
  Instance instance = frameInstance(frame, index);
  Mesh mesh = frameMesh(frame, instance.mesh);
  View view = frameView(frame, push.view);

  vec3 world = instance.objectToWorld * vec4(PositionRef(mesh.positions).v[gl_VertexIndex], 1.0);
  gl_Position = projectToClip(view.projection, view.worldToView * vec4(world, 1.0));

  VertexAttributes attributes = AttributesRef(mesh.attributes).v[gl_VertexIndex];
  mat3 linear = mat3(instance.objectToWorld);
  // Directions only: without the scale, which may be 1e-6 in quantised meshes and would underflow in products.
  linear /= max(max(length(linear[0]), max(length(linear[1]), length(linear[2]))), 1e-37);
  // The cofactor matrix carries normals under any scale, shear or mirror; only the sign of a mirror must be taken out.
  mat3 cofactor = mat3(cross(linear[1], linear[2]), cross(linear[2], linear[0]), cross(linear[0], linear[1]));
  float handedness = (instance.flags & kInstanceMirrored) != 0u ? -1.0 : 1.0;
  varyingPosition = world;
  vec3 normal = handedness * (cofactor * attributes.normal);
  varyingNormal = normal * inversesqrt(max(dot(normal, normal), 1e-37));
  varyingTangent = vec4(linear * attributes.tangent.xyz, attributes.tangent.w * handedness);
  varyingUv = vec4(attributes.uv0, attributes.uv0);
  varyingColor = vec4(1.0);
  if (mesh.extras != 0ul) {
    VertexExtra extra = ExtraRef(mesh.extras).v[gl_VertexIndex];
    varyingUv.zw = extra.uv1;
    varyingColor = extra.color;
  }
  varyingInstance = index;
#ifdef FRAGMENT_ORDER
  varyingDrawn = gl_InstanceIndex;
#endif
#ifdef MOTION
  passMotion(frame, view, mesh, world, index);
#endif
}
