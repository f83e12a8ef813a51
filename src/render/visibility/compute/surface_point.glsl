// The SurfacePoint of a triangle at a pixel, from barycentric coordinates, and the material textures there.
#ifndef LATELIGHT_SURFACE_POINT_GLSL
#define LATELIGHT_SURFACE_POINT_GLSL
#include "render/glsl/material.glsl"
#include "render/glsl/vertex_directions.glsl"
#include "render/visibility/compute/visible_triangle.glsl"

// --- attributes ------------------------------------------------------------------------------------------------------

vec4 uvRight, uvDown;  // UV derivatives per pixel of the current point, for both UV sets

vec3 unitDirection(vec3 direction) { return direction * inversesqrt(max(dot(direction, direction), 1e-37)); }

// Sets normal and tangent, world space. A transform that preserves angles rotates all vertices' directions alike, so
// only the interpolated directions are transformed.
void setDirections(inout SurfacePoint p, VisibleTriangle t, Instance instance, VertexAttributes attributes[3],
                   vec3 weights) {
  float handedness = (instance.flags & kInstanceMirrored) != 0u ? -1.0 : 1.0;
  vec3 normal = vec3(0.0);
  vec4 tangent = vec4(0.0);
  for (int i = 0; i < 3; ++i) {
    normal += weights[i] * unitDirection(attributes[i].normal);
    tangent += weights[i] * attributes[i].tangent;
  }
  mat3 linear = mat3(instance.objectToWorld) / t.draw.stretch;
  p.normal = linear * normal;
  p.tangent = vec4(linear * tangent.xyz, tangent.w * handedness);
  if ((t.draw.flags & kDrawSimilar) == 0u) {
    VertexDirections directions = vertexDirections(instance);
    p.normal = vec3(0.0);
    for (int i = 0; i < 3; ++i) p.normal += weights[i] * worldNormal(directions, attributes[i].normal);
    p.tangent = worldTangent(directions, tangent);
  }
}

// Sets the UV sets with their derivatives, and the vertex color.
void setCoordinates(inout SurfacePoint p, VisibleTriangle t, Mesh mesh, Instance instance,
                    VertexAttributes attributes[3],
                    Weights w) {
  vec2 uv = vec2(0.0), right = vec2(0.0), down = vec2(0.0);
  for (int i = 0; i < 3; ++i) {
    uv += w.at[i] * attributes[i].uv0;
    right += w.right[i] * attributes[i].uv0;
    down += w.down[i] * attributes[i].uv0;
  }
  p.uv = vec4(uv, uv);
  p.color = vec4(1.0);
  uvRight = vec4(right, right);
  uvDown = vec4(down, down);
  if (hasExtras(instance)) {
    p.uv.zw = uvRight.zw = uvDown.zw = vec2(0.0);
    p.color = vec4(0.0);
    for (int i = 0; i < 3; ++i) {
      VertexExtra extra = ExtraRef(mesh.extras).v[t.indices[i]];
      p.uv.zw += w.at[i] * extra.uv1;
      p.color += w.at[i] * extra.color;
      uvRight.zw += w.right[i] * extra.uv1;
      uvDown.zw += w.down[i] * extra.uv1;
    }
  }
}

// Sets the position and the first UV set on a vast triangle, where cancellation requires double-float arithmetic.
void setVastPlace(inout SurfacePoint p, FrameConstants frame, View view, VisibleTriangle t, vec2 pixel,
                  VertexAttributes attributes[3]) {
  Exact3 corners[3] = vastCornersOf(frame, view, t);
  vec3 seen = vastPoint(frame, view, corners, pixel);
  p.position = toWorldAxes(view, seen) + view.eye;
  VastWeights w = vastWeights(corners[0], corners[1], corners[2], exact(seen));
  p.uv.xy = attributeOf(w, vec3(attributes[0].uv0, 0.0), vec3(attributes[1].uv0, 0.0), vec3(attributes[2].uv0, 0.0)).xy;
  if (!hasExtras(frameInstance(frame, t.draw.instance))) p.uv.zw = p.uv.xy;
}

SurfacePoint visiblePoint(FrameConstants frame, View view, VisibleTriangle t, vec2 pixel) {
  Instance instance = frameInstance(frame, t.draw.instance);
  Mesh mesh = frameMesh(frame, t.draw.mesh);
  mat4x3 placed = relativeToEye(instance, view);
  vec3 corners[3];  // relative to the eye, in world axes
  VertexAttributes attributes[3];
  for (int i = 0; i < 3; ++i) {
    corners[i] = placed * vec4(positionAt(mesh.positions, t.indices[i]), 1.0);
    attributes[i] = attributesAt(mesh.attributes, t.indices[i]);
  }
  Weights w = weightsAt(frame, view, toView(view, corners[0]), toView(view, corners[1]), toView(view, corners[2]),
                        pixel);
  SurfacePoint p;
  p.position = corners[0] * w.at.x + corners[1] * w.at.y + corners[2] * w.at.z + view.eye;
  setDirections(p, t, instance, attributes, w.at);
  setCoordinates(p, t, mesh, instance, attributes, w);
  if (isVast(t)) setVastPlace(p, frame, view, t, pixel, attributes);
  vec3 plane = cross(corners[1] - corners[0], corners[2] - corners[0]);
  if ((instance.flags & kInstanceClockwise) != 0u) plane = -plane;
  vec3 toEye = view.projection.kind == kPerspective ? -corners[0] : view.viewToWorld * vec4(0.0, -1.0, 0.0, 0.0);
  p.facing = dot(plane, toEye) >= 0.0 ? 1.0 : -1.0;
  p.plane = plane * p.facing;
  p.instance = t.draw.instance;
  p.mesh = t.draw.mesh;
  p.triangle = t.number;
  return p;
}

// --- textures --------------------------------------------------------------------------------------------------------

// The texture coordinates of a material's texture at the point, and their derivatives per pixel to the right and down.
struct TextureLookup {
  vec2 uv, right, down;
};
TextureLookup textureLookup(Material m, uint slot, SurfacePoint p) {
  TextureLookup place = TextureLookup(p.uv.xy, uvRight.xy, uvDown.xy);
  if ((m.flags & kMaterialPlainUv) == 0u) {
    TextureTransform t = m.transforms[slot];
    place = TextureLookup(transformedUv(t, p.uv), transformedGradient(t, uvRight), transformedGradient(t, uvDown));
  }
  return place;
}

#ifdef TEXTURES_BY_INDEX
layout(set = 1, binding = 0) uniform sampler2D materialTextures[];
vec4 sampleTexture(Material m, uint slot, SurfacePoint p) {
  TextureLookup place = textureLookup(m, slot, p);
  return textureGrad(materialTextures[nonuniformEXT(m.images[slot])], place.uv, place.right, place.down);
}
#elif defined(BINDS_TEXTURES)
// Set 1: the textures of a group of materials (GpuMaterials::textureGroups()).
#define DECLARE(n) layout(set = 1, binding = n) uniform sampler2D materialTexture##n;
PLAIN_SLOTS(DECLARE)
// lavapipe approximates the logarithm that gives the level of a gradient, but not a given level.
float levelOf(TextureLookup place, vec2 size) {
  return log2(max(max(length(place.right * size), length(place.down * size)), 1e-18));
}
vec4 sampleTexture(Material m, uint slot, SurfacePoint p) {
  TextureLookup place = textureLookup(m, slot, p);
#define SAMPLE(n) \
  case uint(n): return textureLod(materialTexture##n, place.uv, levelOf(place, vec2(textureSize(materialTexture##n, 0))));
  switch (slot) {
    PLAIN_SLOTS(SAMPLE)
    default: return vec4(0.0);
  }
}
#else
#include "render/glsl/texels.glsl"
layout(constant_id = kCodedTextureSlotsConstant) const uint kCodedTextureSlots = ~0u;
uint64_t textureRecords;  // FrameConstants::textures
vec4 sampleTexture(Material m, uint slot, SurfacePoint p) {
  TextureLookup place = textureLookup(m, slot, p);
  TextureRecord t = textureAt(textureRecords, m.images[slot]);
  if ((kCodedTextureSlots >> slot & 1u) == 0u) t.flags &= ~kTextureSrgb;  // the compiler removes the decoding
  return filteredTexture(t, place.uv, place.right, place.down);
}
#endif

#endif
