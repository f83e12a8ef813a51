// The structs that shaders and C++ share. On the device they have scalar block layout, which is the C++ layout: offsets
// agree by construction, sizes are asserted below, and a test compares the offsets with SPIR-V reflection. Angles are
// in radians, lengths in meters, colors in linear Rec.709. All positions and directions are in world space (Z up).
//
// World space on the device has its origin near the scene (GpuScene::origin()), wherever the scene lies. Rendering is
// camera-relative: the positions of instances and eyes are pairs of floats, a value and the remainder of the double
// that it rounds. Their differences place vertices relative to the eye (relativeToEye() in glsl/common.glsl), so depth
// is as precise far from the scene's origin as near it.
#ifndef LATELIGHT_SHARED_TYPES_H
#define LATELIGHT_SHARED_TYPES_H

#include "shared/cluster.h"
#include "shared/fog.h"
#include "shared/lang.h"
#include "shared/projection.h"

SH_BEGIN

// --- geometry -------------------------------------------------------------------------------------------------------

struct VertexPosition {  // one per vertex, in object space
  vec3 position;
  float padding;
};
SH_CONST uint kPositionBytes = 16u;

struct VertexAttributes {  // one per vertex, in object space
  vec3 normal;
  vec4 tangent;  // xyz, and the sign of the bitangent in w; all zero if the mesh has no tangent frame
  vec2 uv0;
  float padding[3];
};
SH_CONST uint kAttributesBytes = 48u;

struct VertexExtra {  // 24 bytes, one per vertex, only for meshes with a second UV set or vertex colors
  vec2 uv1;
  vec4 color;  // linear, multiplies the base color
};

struct Mesh {                  // addresses of one mesh's vertex and index buffers in device memory
  uint64_t positions;          // VertexPosition[vertexCount]
  uint64_t attributes;         // VertexAttributes[vertexCount]
  uint64_t extras;             // VertexExtra[vertexCount], or 0
  uint64_t indices;            // uint[3 * triangleCount]
  uint64_t previousPositions;  // positions in the previous frame; equal to `positions` if nothing deforms the mesh
  uint64_t nextPositions;      // positions in the next frame, likewise
  MeshClusters clusters;       // zeros if the mesh has no clusters
  uint vertexCount;
  uint triangleCount;
};
SH_CONST uint kMeshBytes = 96u;

struct Instance {
  mat4x3 objectToWorld;  // affine, column vectors
  uint mesh;
  uint material;
  uint id;  // value of the data output id: stable, never 0
  uint part;
  uint flags;           // kInstance* flags, and the group number from bit kInstanceGroupShift on
  vec3 translationLow;  // low part of the translation, which the last column of objectToWorld rounds off
};
SH_CONST uint kInstanceBytes = 80u;
SH_CONST uint kInstanceMirrored = 1u;   // objectToWorld has a negative determinant
SH_CONST uint kInstanceExtras = 2u;     // the mesh has VertexExtra
SH_CONST uint kInstanceClockwise = 4u;  // front faces are clockwise: either the transform or the skin mirrors, but not
                                        // both
SH_CONST uint kInstanceVast = 8u;       // has triangles so large that floats place their vertices inaccurately
SH_CONST uint kInstanceGroupShift = 16u;

// --- materials ------------------------------------------------------------------------------------------------------

SH_CONST uint kTextureBaseColor = 0u;
SH_CONST uint kTextureMetallicRoughness = 1u;
SH_CONST uint kTextureNormal = 2u;
SH_CONST uint kTextureOcclusion = 3u;
SH_CONST uint kTextureEmissive = 4u;
SH_CONST uint kTextureSpecular = 5u;
SH_CONST uint kTextureSpecularColor = 6u;
SH_CONST uint kTextureClearcoat = 7u;  // first of the textures of MaterialLayers
SH_CONST uint kTextureClearcoatRoughness = 8u;
SH_CONST uint kTextureClearcoatNormal = 9u;
SH_CONST uint kTextureSheenColor = 10u;
SH_CONST uint kTextureSheenRoughness = 11u;
SH_CONST uint kTextureAnisotropy = 12u;
SH_CONST uint kTextureIridescence = 13u;
SH_CONST uint kTextureIridescenceThickness = 14u;
SH_CONST uint kTextureTransmission = 15u;
SH_CONST uint kTextureThickness = 16u;
SH_CONST uint kTextureDiffuseTransmission = 17u;
SH_CONST uint kTextureDiffuseTransmissionColor = 18u;
SH_CONST uint kTextureCount = 19u;

struct TextureTransform {  // KHR_texture_transform as an affine map: uv' = (dot(row0, (u,v,1)), dot(row1, (u,v,1)))
  vec3 row0;
  vec3 row1;
  uint uvSet;  // 0 or 1
};

// The coats and transmissive extensions that a material has, as bits (scene::layersOf()).
SH_CONST uint kLayerClearcoat = 1u;
SH_CONST uint kLayerSheen = 2u;
SH_CONST uint kLayerAnisotropy = 4u;
SH_CONST uint kLayerIridescence = 8u;
SH_CONST uint kLayerTransmission = 16u;
SH_CONST uint kLayerVolume = 32u;  // only set for surfaces that transmit light
SH_CONST uint kLayerDispersion = 64u;
SH_CONST uint kLayerDiffuseTransmission = 128u;

struct MaterialLayers {  // coats over the surface and transmission through it: the KHR_materials_* extensions
  float clearcoat;
  float clearcoatRoughness;
  float clearcoatNormalScale;
  float sheenRoughness;
  vec3 sheenColor;
  float anisotropy;
  float anisotropyRotation;  // counter-clockwise from the tangent
  float iridescence;
  float iridescenceIor;
  float iridescenceThinnest;  // nanometers, where the texture is 0
  float iridescenceThickest;  // where the texture is 1, or without a texture
  float transmission;
  float thickness;  // meters in object space; 0: thin-walled
  float dispersion;
  vec3 attenuationColor;      // color of white light after attenuationDistance
  float attenuationDistance;  // meters; 0: no attenuation
  vec3 diffuseTransmissionColor;
  float diffuseTransmission;
};

struct Material {
  vec4 baseColor;
  vec3 emissive;  // KHR_materials_emissive_strength included
  float metallic;
  float roughness;
  float normalScale;
  float occlusionStrength;
  float alphaCutoff;
  vec3 specularColor;  // KHR_materials_specular
  float specular;
  float f0;       // reflectance of the dielectric at normal incidence, ((ior - 1) / (ior + 1))^2 of KHR_materials_ior
  uint flags;     // kMaterial*
  uint textures;  // bit i: the material has texture slot i; from kTextureGroupShift on: textureGroup()
  uint id;        // value of the data output material: stable, never 0
  TextureTransform transforms[19];
  uint images[19];  // bindless index of the texture and sampler per slot (descriptor indexing)
  MaterialLayers layers;
};
SH_CONST uint kMaterialBytes = 784u;
// Materials of one texture group sample the same textures with the same samplers. Always 0 on a GPU, and if there are
// more than kMaxTextureGroups materials, of whose groups the passes and pipelines would take longer than they save.
SH_CONST uint kTextureGroupShift = 24u, kMaxTextureGroups = 16u;
SH_FUNC uint textureGroup(uint textures) {
  return textures >> kTextureGroupShift;
}
// Places of members, in words.
SH_CONST uint kMaterialFlagsAt = 17u;
SH_CONST uint kMaterialTexturesAt = 18u;
SH_CONST uint kMaterialTransformsAt = 20u;
SH_CONST uint kTransformWords = 7u;
SH_CONST uint kMaterialImagesAt = 153u;

// A texture and its sampler for compute shaders that filter in software, on devices without descriptor indexing.
struct TextureRecord {
  uint64_t texels;     // RGBA8, mip level after mip level
  uint width, height;  // of level 0
  uint levels;
  uint flags;       // kTexture*
  uint anisotropy;  // maximum number of samples along a pixel's footprint
  uint padding;
};
SH_CONST uint kTextureRecordBytes = 32u;
SH_CONST uint kTextureSrgb = 1u;
SH_CONST uint kTextureMagnifyNearest = 2u;
SH_CONST uint kTextureMinifyNearest = 4u;
SH_CONST uint kTextureMipNearest = 8u;
SH_CONST uint kTextureMipNone = 16u;
SH_CONST uint kTextureWrapShift = 8u;  // two bits for u, then two bits for v: 0 repeat, 1 mirror, 2 clamp

SH_CONST uint kMaterialUnlit = 1u;
SH_CONST uint kMaterialMasked = 2u;  // alpha tested against alphaCutoff
SH_CONST uint kMaterialDoubleSided = 4u;
SH_CONST uint kMaterialBlended = 8u;  // alpha blended with the background; never set together with kMaterialMasked
// Set only in the device's records, from the material's layers and texture transforms.
SH_CONST uint kMaterialLayered = 16u;       // the material has any kLayer* bit
SH_CONST uint kMaterialTransmissive = 32u;  // the surface transmits the background (KHR_materials_transmission)
SH_CONST uint kMaterialPlainUv = 64u;       // all textures use UV set 0 without a transform

// Traits that all materials or all meshes of a scene share, for which shaders of CPU devices are specialized
// (GpuScene::traits).
SH_CONST uint kTraitPlainUv = 1u;          // kMaterialPlainUv
SH_CONST uint kTraitPlainSpecular = 2u;    // no material has KHR_materials_specular
SH_CONST uint kTraitSharedOcclusion = 4u;  // occlusion is the red channel of the metallic-roughness texture
SH_CONST uint kTraitNoExtras = 8u;         // no mesh has VertexExtra

// True if the material is translucent: it is drawn over the background instead of replacing it.
SH_FUNC bool translucent(uint materialFlags) {
  return (materialFlags & (kMaterialBlended | kMaterialTransmissive)) != 0u;
}

// --- lights ---------------------------------------------------------------------------------------------------------

// The region that a type of light reaches.
SH_CONST uint kReachEverywhere = 0u;  // everywhere: the light has a direction and no position
SH_CONST uint kReachSphere = 1u;      // the sphere of its radius
SH_CONST uint kReachCone = 2u;        // the part of that sphere within its cone
SH_CONST uint kReachArea = 3u;        // everywhere that its shape emits to: an AreaLight and no Light

struct Light {  // KHR_lights_punctual
  vec3 position;
  float inverseRadius2;  // 1 / radius^2; 0 if unbounded
  vec3 intensity;        // color times candela, or lux for kReachEverywhere
  uint type;             // kLight*: index of its file in shared/light, in alphabetical order
  vec3 direction;        // from the light, unit
  float radius;          // meters: glTF's range, where the window (shared/light.h) reaches 0; +inf if unbounded
  float spotScale;       // spot cone: clamp(cos * spotScale + spotOffset, 0, 1)^2
  float spotOffset;
  float size;  // of the penumbrae that rays find: a radius in meters, or the tangent of a directional light's radius
  float padding;
};
SH_CONST uint kLightBytes = 64u;

// A shape that emits uniform radiance (shared/area_light.h). With points p of the space of the shape, its points in the
// world are center + x p.x + y p.y + z p.z. A rectangle has |p.x| <= 1 and |p.y| <= 1, a disk |p| <= 1, both with p.z =
// 0; a sphere |p| <= 1; a tube |p.x| <= 1 and |p.yz| <= 1.
struct AreaLight {  // 80 bytes
  vec3 center;
  uint type;  // kLight*
  vec3 x;
  uint twoSided;  // rectangles and disks: 1 if both sides emit
  vec3 y;
  uint orthogonal;  // 1: x and y are perpendicular
  vec3 z;           // rectangles and disks: unit, on the emitting side
  uint padding0;
  vec3 radiance;  // W/sr/m^2 or nits, per color channel
  uint padding1;
};
SH_CONST uint kAreaLightBytes = 80u;

// Area lights of a scene: each surface is shaded with all of them.
SH_CONST uint kMaxAreaLights = 64u;

// The area lights that a pass shades, as the specialization constant kAreaLights.
SH_CONST uint kAreaLightsNone = 0u;
SH_CONST uint kAreaLightsAll = 1u;
SH_CONST uint kAreaLightsUnshadowed = 2u;  // those that FrameConstants::areaShadows leaves out

// --- shadows --------------------------------------------------------------------------------------------------------

// The shadow-casting lights differ per view, and they are few. The bit of a light is set if it casts shadows in any
// view. The lights with set bits are numbered in order; this number is a light's column in
// FrameConstants::lightShadows, which has one row per view.
struct ShadowBits {  // one word of 32 lights
  uint lights;       // bit i of word w: light 32 w + i of the frame
  uint before;       // number of set bits in all previous words
};

struct LightShadow {  // one light in one view
  uint first;         // index of its first map in FrameConstants::shadowMaps
  uint maps;  // number of its maps: cascades of a directional light, finest first; 6 faces of a cube or 1 map of a
              // local light; 0: the light casts no shadows in this view
  uint sun;   // 1: the first directional light with shadows, for which layouts may have a channel
};

// One square tile of the shadow atlas, and the part of the world that it covers (render/shadow). Let q = dot(row, (p,
// 1)) for a world position p and each of the three rows. The texel is (q.across, q.down) / w, where w is q.away in a
// perspective map and 1 in an orthographic one. The depth is q.away * depthScale + depthOffset: from 0 to 1, and linear
// in meters.
struct ShadowMap {
  vec4 across;
  vec4 down;
  vec4 away;  // meters along the map's axis
  float depthScale;
  float depthOffset;
  float depthSlack;   // error bound of the format and of rounding, in depth
  float texel;        // width of a texel at w = 1, meters
  float perspective;  // 1, or 0 for an orthographic map
  float lightSize;    // radius of the light in meters; for a directional light, the tangent of its angular radius
  uvec2 corner;       // first texel of the tile in the atlas
  float size;         // side of the tile, texels
  uint layer;         // array layer of the atlas
  uint padding[2];
};
SH_CONST uint kShadowMapBytes = 96u;

// The light tree: a bounding volume hierarchy (BVH) over the local lights (point and spot). It is an implicit tree
// without pointers: the children of node h are nodes kLightTreeWidth * (h + 1) + i, and the children of the root, which
// has no box, are nodes i. Nodes from FrameConstants::lightTreeLeaves on are leaves; leaf l bounds the local lights
// kLightTreeWidth * l + i. Slots without a node hold an empty box.
SH_CONST uint kLightTreeBits = 5u;  // at most 5
SH_CONST uint kLightTreeWidth = 1u << kLightTreeBits;

struct LightBox {  // 24 bytes: bounds of the lights' reach, world space
  vec3 low;
  vec3 high;
};

// --- frame ----------------------------------------------------------------------------------------------------------

struct View {
  mat4x3 worldToView;  // rigid; view space is X right, Y away, Z up
  mat4x3 viewToWorld;
  Projection projection;  // jitter included
  vec3 eye;               // world
  vec2 size;              // pixels
  vec2 jitter;            // NDC: the part of the projection's principal point that jitters the samples
  uint group;             // the view renders only instances of this group; 0: all instances
  vec3 eyeLow;            // low part of the eye's position, which `eye` rounds off
  uint world;             // index of the view's world; 0 without worlds. Only the host reads it.
  uint padding;
};
SH_CONST uint kViewBytes = 176u;

// The ray of one pixel through a lens. In such a view, depth along the ray replaces depth along Y.
struct LensRay {
  vec3 direction;  // view space, unit; 0: the lens has no ray there
  float depth;     // value of the data output `depth` per meter along the ray
};

// With worlds (docs/worlds.md), every view has its own constants, which follow each other in the order of the views:
// those of its world. Otherwise all views share one.
struct FrameConstants {
  uint64_t views;         // View[viewCount]
  uint64_t instances;     // Instance[]
  uint64_t meshes;        // Mesh[]
  uint64_t materials;     // Material[]
  uint64_t textures;      // TextureRecord[], if compute shaders filter textures in software; else 0
  uint64_t lights;        // Light[lightCount]: first directional lights, then local ones in the light tree's order
  uint64_t lightTree;     // LightBox[]
  uint64_t shadowBits;    // ShadowBits[(lightCount + 31) / 32]
  uint64_t lightShadows;  // LightShadow[viewCount][shadowColumns]
  uint64_t shadowMaps;    // ShadowMap[]; with shadows by rays, RayShadow[] (shared/rays.h)
  // The previous and the next frame: arrays like `instances` and `views`, or the same addresses if nothing moves.
  uint64_t previousInstances;
  uint64_t nextInstances;
  uint64_t previousViews;  // without jitter
  uint64_t nextViews;
  uint64_t rays;  // for lenses: LensRay[height + 2][width] of all views, from the row above the picture on; else 0
  uint64_t rasterInstances;  // with worlds and the raster compute: RasterInstance[] of the view's world; else 0
  // RayScene (shared/rays.h), if shaders trace rays through the scene; else 0.
  uint64_t rayScene;
  uint viewCount;
  uint lightCount;
  uint directionalLights;
  uint lightTreeLeaves;        // index of the first leaf in lightTree
  uint shadowColumns;          // number of lights that cast shadows in any view
  float exposure;              // linear factor
  float environmentIntensity;  // 0: no environment
  float environmentCos;        // rotation about Z (shared/environment.h)
  float environmentSin;
  float aoRadius;           // of ambient occlusion, in meters
  float environmentLevels;  // number of prefiltered levels, from roughness 0 at level 0 to roughness 1 at the last
  Fog fog;                  // applied to all surfaces, including blended ones, and to the background
  vec3 positionOffset;      // from device world space to that of the output `position`, as a pair of floats: high part
  vec3 positionOffsetLow;
  uint64_t areaLights;  // AreaLight[areaLightCount]
  uint64_t ltcTable;    // LtcFit[kLtcSize][kLtcSize] (shared/area_light.h), if there are area lights
  uint areaLightCount;
  uvec2 areaShadows;  // bit i of both words: rays find the shadows of area light i
  // With worlds: the layer of the environment's maps, and the level of the specular map that is its level 0.
  uint environmentMap;
};
SH_CONST uint kFrameBytes = 264u;
// Indices of members in units of 8 bytes, for glsl/uniform_loads.glsl: `lights`, and `viewCount`, which begins the six
// units up to environmentLevels.
SH_CONST uint kFrameLightsAt = 5u;
SH_CONST uint kFrameCountsAt = 17u;

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::VertexPosition) == latelight::shared::kPositionBytes);
static_assert(sizeof(latelight::shared::VertexAttributes) == latelight::shared::kAttributesBytes);
static_assert(sizeof(latelight::shared::VertexExtra) == 24);
static_assert(sizeof(latelight::shared::Mesh) == latelight::shared::kMeshBytes);
static_assert(sizeof(latelight::shared::Instance) == latelight::shared::kInstanceBytes);
static_assert(sizeof(latelight::shared::TextureTransform) == 28);
static_assert(sizeof(latelight::shared::MaterialLayers) == 96);
static_assert(sizeof(latelight::shared::Material) == 80 + 19 * 28 + 19 * 4 + 96);
static_assert(sizeof(latelight::shared::Material) == latelight::shared::kMaterialBytes);
static_assert(offsetof(latelight::shared::Material, flags) == 4 * latelight::shared::kMaterialFlagsAt);
static_assert(offsetof(latelight::shared::Material, textures) == 4 * latelight::shared::kMaterialTexturesAt);
static_assert(offsetof(latelight::shared::Material, transforms) == 4 * latelight::shared::kMaterialTransformsAt);
static_assert(sizeof(latelight::shared::TextureTransform) == 4 * latelight::shared::kTransformWords);
static_assert(offsetof(latelight::shared::Material, images) == 4 * latelight::shared::kMaterialImagesAt);
static_assert(sizeof(latelight::shared::TextureRecord) == latelight::shared::kTextureRecordBytes);
static_assert(sizeof(latelight::shared::Material) % 16 == 0);
static_assert(sizeof(latelight::shared::Light) == latelight::shared::kLightBytes);
static_assert(sizeof(latelight::shared::AreaLight) == latelight::shared::kAreaLightBytes);
static_assert(sizeof(latelight::shared::ShadowMap) == latelight::shared::kShadowMapBytes);
static_assert(sizeof(latelight::shared::LightBox) == 24);
static_assert(sizeof(latelight::shared::View) == latelight::shared::kViewBytes);
static_assert(sizeof(latelight::shared::FrameConstants) == latelight::shared::kFrameBytes);
// glsl/uniform_loads.glsl loads members at these offsets.
static_assert(offsetof(latelight::shared::FrameConstants, views) == 0);
static_assert(offsetof(latelight::shared::FrameConstants, lights) == 8 * latelight::shared::kFrameLightsAt);
static_assert(offsetof(latelight::shared::FrameConstants, viewCount) == 8 * latelight::shared::kFrameCountsAt);
static_assert(offsetof(latelight::shared::FrameConstants, directionalLights) ==
              8 * (latelight::shared::kFrameCountsAt + 1));
static_assert(offsetof(latelight::shared::FrameConstants, shadowColumns) ==
              8 * (latelight::shared::kFrameCountsAt + 2));
static_assert(offsetof(latelight::shared::FrameConstants, environmentIntensity) ==
              8 * (latelight::shared::kFrameCountsAt + 3));
static_assert(offsetof(latelight::shared::FrameConstants, environmentSin) ==
              8 * (latelight::shared::kFrameCountsAt + 4));
static_assert(offsetof(latelight::shared::FrameConstants, environmentLevels) ==
              8 * (latelight::shared::kFrameCountsAt + 5));
static_assert(offsetof(latelight::shared::View, viewToWorld) == 48);
static_assert(offsetof(latelight::shared::View, projection) == 96);
static_assert(offsetof(latelight::shared::View, eye) == 124);
static_assert(offsetof(latelight::shared::View, size) == 136);
static_assert(offsetof(latelight::shared::View, jitter) == 144);
static_assert(offsetof(latelight::shared::View, group) == 152);
static_assert(offsetof(latelight::shared::View, eyeLow) == 156);
#endif

#endif
