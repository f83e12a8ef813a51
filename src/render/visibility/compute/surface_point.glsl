// The point of the scene that a pixel shows, and the textures there.
#ifndef LATELIGHT_SURFACE_POINT_GLSL
#define LATELIGHT_SURFACE_POINT_GLSL
#include "render/glsl/material.glsl"
#include "render/glsl/vertex_directions.glsl"
#include "render/visibility/compute/seen_triangle.glsl"

// --- what is there --------------------------------------------------------------------------------------------------

vec4 uvRight, uvDown;  // of the point that is being looked at, in both UV sets

VertexExtra extraOf(Mesh mesh, Instance instance, VertexAttributes attributes, uint vertex) {
  if ((instance.flags & kInstanceExtras) != 0u) return ExtraRef(mesh.extras).v[vertex];
  return VertexExtra(attributes.uv0, vec4(1.0));
}

SurfacePoint seenPoint(FrameConstants frame, View view, SeenTriangle t, vec2 pixel) {
  Instance instance = frameInstance(frame, t.rank.instance);
  Mesh mesh = frameMesh(frame, t.rank.mesh);
  vec3 world[3];
  VertexAttributes attributes[3];
  VertexExtra extras[3];
  for (int i = 0; i < 3; ++i) {
    world[i] = instance.objectToWorld * vec4(positionAt(mesh.positions, t.indices[i]), 1.0);
    attributes[i] = attributesAt(mesh.attributes, t.indices[i]);
    extras[i] = extraOf(mesh, instance, attributes[i], t.indices[i]);
  }
  Weights w = weightsAt(frame, view, view.worldToView * vec4(world[0], 1.0), view.worldToView * vec4(world[1], 1.0),
                        view.worldToView * vec4(world[2], 1.0), pixel);
  VertexDirections directions = vertexDirections(instance);
  SurfacePoint p;
  p.position = vec3(0.0);
  p.normal = vec3(0.0);
  p.tangent = vec4(0.0);
  p.uv = vec4(0.0);
  p.color = vec4(0.0);
  uvRight = vec4(0.0);
  uvDown = vec4(0.0);
  for (int i = 0; i < 3; ++i) {
    vec4 uv = vec4(attributes[i].uv0, extras[i].uv1);
    p.position += w.at[i] * world[i];
    p.normal += w.at[i] * worldNormal(directions, attributes[i].normal);
    p.tangent += w.at[i] * worldTangent(directions, attributes[i].tangent);
    p.uv += w.at[i] * uv;
    p.color += w.at[i] * extras[i].color;
    uvRight += w.right[i] * uv;
    uvDown += w.down[i] * uv;
  }
  vec3 ab = world[1] - world[0], ac = world[2] - world[0];
  vec3 plane = cross(ab, ac) * directions.handedness;
  vec3 toEye = view.projection.kind == kPerspective ? view.eye - world[0] : view.viewToWorld * vec4(0.0, -1.0, 0.0, 0.0);
  p.facing = dot(plane, toEye) >= 0.0 ? 1.0 : -1.0;
  p.plane = plane * p.facing;
  p.instance = t.rank.instance;
  p.mesh = t.rank.mesh;
  p.triangle = t.number;
  return p;
}

// --- textures -------------------------------------------------------------------------------------------------------

#ifdef TEXTURES_BY_INDEX
layout(set = 1, binding = 0) uniform sampler2D materialTextures[];
vec4 sampleTexture(Material m, uint slot, SurfacePoint p) {
  TextureTransform t = m.transforms[slot];
  return textureGrad(materialTextures[nonuniformEXT(m.images[slot])], transformedUv(t, p.uv), transformedGradient(t, uvRight),
                     transformedGradient(t, uvDown));
}
#else
#include "render/visibility/compute/texels.glsl"
uint64_t textureRecords;  // FrameConstants::textures
vec4 sampleTexture(Material m, uint slot, SurfacePoint p) {
  TextureTransform t = m.transforms[slot];
  return filteredTexture(TextureRef(textureRecords).v[m.images[slot]], transformedUv(t, p.uv),
                         transformedGradient(t, uvRight), transformedGradient(t, uvDown));
}
#endif

#endif
