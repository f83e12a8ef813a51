// Every struct that both shaders and C++ read, once. Scalar block layout on the device is C++ layout: offsets agree by
// construction, sizes are asserted below, and tests compare offsets with SPIR-V reflection.
// Angles in radians, lengths in meters, colors linear Rec.709, all positions and directions in world space (Z up).
//
// World space on the device has its origin near the scene (GpuScene::origin()), wherever the scene lies. What the raster
// needs exactly, the positions of instances and eyes, are pairs of floats: a value, and the rest of the double that it
// rounds. Their differences place vertices relative to the eye (relativeToEye() in glsl/common.glsl), which is what makes
// depth as precise far from the origin as it is there.
#ifndef LATELIGHT_SHARED_TYPES_H
#define LATELIGHT_SHARED_TYPES_H

#include "shared/cluster.h"
#include "shared/fog.h"
#include "shared/lang.h"
#include "shared/projection.h"

SH_BEGIN

// --- geometry -------------------------------------------------------------------------------------------------------

struct VertexPosition {  // one a vertex, in object space
  vec3 position;
  float padding;
};
SH_CONST uint kPositionBytes = 16u;

struct VertexAttributes {  // one a vertex, in object space
  vec3 normal;
  vec4 tangent;  // xyz, and the sign of the bitangent in w; all zero where the mesh has no tangent frame
  vec2 uv0;
  float padding[3];
};
SH_CONST uint kAttributesBytes = 48u;

struct VertexExtra {  // 24 bytes, one a vertex, only for meshes that have a second UV set or vertex colours
  vec2 uv1;
  vec4 color;  // linear, multiplies the base colour
};

struct Mesh {                  // where one mesh's streams lie in device memory
  uint64_t positions;          // VertexPosition[vertexCount]
  uint64_t attributes;         // VertexAttributes[vertexCount]
  uint64_t extras;             // VertexExtra[vertexCount], or 0
  uint64_t indices;            // uint[3 * triangleCount]
  uint64_t previousPositions;  // as positions, a frame before; the same where nothing deforms them
  uint64_t nextPositions;      // and a frame after
  MeshClusters clusters;       // zeros where none are kept
  uint vertexCount;
  uint triangleCount;
};

struct Instance {
  mat4x3 objectToWorld;  // affine, column vectors
  uint mesh;
  uint material;
  uint id;  // the values of the data outputs id and part: stable, never 0
  uint part;
  uint flags;  // kInstance*, and its group from kInstanceGroupShift on
  vec3 translationLow;  // what the last column of objectToWorld leaves of the translation
};
SH_CONST uint kInstanceBytes = 80u;
SH_CONST uint kInstanceMirrored = 1u;   // objectToWorld has a negative determinant
SH_CONST uint kInstanceExtras = 2u;     // its mesh has VertexExtra
SH_CONST uint kInstanceClockwise = 4u;  // front faces are clockwise: the transform or the skin mirrors, but not both
SH_CONST uint kInstanceVast = 8u;       // has triangles so large that floats place their corners badly
SH_CONST uint kInstanceGroupShift = 16u;

// --- materials ------------------------------------------------------------------------------------------------------

SH_CONST uint kTextureBaseColor = 0u;
SH_CONST uint kTextureMetallicRoughness = 1u;
SH_CONST uint kTextureNormal = 2u;
SH_CONST uint kTextureOcclusion = 3u;
SH_CONST uint kTextureEmissive = 4u;
SH_CONST uint kTextureSpecular = 5u;
SH_CONST uint kTextureSpecularColor = 6u;
SH_CONST uint kTextureClearcoat = 7u;  // from here on those of MaterialLayers
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

// Which of them a material has: scene::layersOf().
SH_CONST uint kLayerClearcoat = 1u;
SH_CONST uint kLayerSheen = 2u;
SH_CONST uint kLayerAnisotropy = 4u;
SH_CONST uint kLayerIridescence = 8u;
SH_CONST uint kLayerTransmission = 16u;
SH_CONST uint kLayerVolume = 32u;  // of a surface that lets light pass
SH_CONST uint kLayerDispersion = 64u;
SH_CONST uint kLayerDiffuseTransmission = 128u;

struct MaterialLayers {  // what the extensions KHR_materials_* lay over a surface, and what it lets through
  float clearcoat;
  float clearcoatRoughness;
  float clearcoatNormalScale;
  float sheenRoughness;
  vec3 sheenColor;
  float anisotropy;
  float anisotropyRotation;  // counter-clockwise from the tangent
  float iridescence;
  float iridescenceIor;
  float iridescenceThinnest;  // nanometres, where the texture is 0
  float iridescenceThickest;  // where it is 1, or where there is none
  float transmission;
  float thickness;  // metres in object space; 0: thin-walled
  float dispersion;
  vec3 attenuationColor;      // what is left of white light after attenuationDistance
  float attenuationDistance;  // metres; 0: nothing is lost, however far
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
  float f0;       // of the dielectric, from KHR_materials_ior: ((ior - 1) / (ior + 1))^2
  uint flags;     // kMaterial*
  uint textures;  // bit i: texture slot i is present
  uint id;        // the value of the data output material: stable, never 0
  TextureTransform transforms[19];
  uint images[19];  // by slot: its texture and sampler among the scene's, where shaders find them by index
  MaterialLayers layers;
};
SH_CONST uint kMaterialBytes = 784u;
// A texture and its sampler, for shaders that filter themselves: where the device has no descriptor indexing.
struct TextureRecord {  // 28 bytes
  uint64_t texels;      // RGBA8, level after level
  uint width, height;   // of level 0
  uint levels;
  uint flags;       // kTexture*
  uint anisotropy;  // samples along a pixel's footprint, at most
};
SH_CONST uint kTextureSrgb = 1u;
SH_CONST uint kTextureMagnifyNearest = 2u;
SH_CONST uint kTextureMinifyNearest = 4u;
SH_CONST uint kTextureMipNearest = 8u;
SH_CONST uint kTextureMipNone = 16u;
SH_CONST uint kTextureWrapShift = 8u;  // u's, and v's two bits higher: 0 repeat, 1 mirror, 2 clamp

SH_CONST uint kMaterialUnlit = 1u;
SH_CONST uint kMaterialMasked = 2u;  // alphaCutoff applies
SH_CONST uint kMaterialDoubleSided = 4u;
SH_CONST uint kMaterialBlended = 8u;  // alpha lets through what lies behind; never with kMaterialMasked
// Of the device's records alone, by the layers.
SH_CONST uint kMaterialLayered = 16u;       // some layer is there
SH_CONST uint kMaterialTransmissive = 32u;  // what lies behind shows through the surface itself
SH_CONST uint kMaterialPlainUv = 64u;       // its textures lie as UV set 0 has them

// Whether it is drawn over what lies behind it, rather than instead.
SH_FUNC bool seenThrough(uint materialFlags) {
  return (materialFlags & (kMaterialBlended | kMaterialTransmissive)) != 0u;
}

// --- lights ---------------------------------------------------------------------------------------------------------

// What a type of light reaches.
SH_CONST uint kReachEverywhere = 0u;  // it has a direction and no place
SH_CONST uint kReachSphere = 1u;      // as far as its radius
SH_CONST uint kReachCone = 2u;        // as far, within its cone

struct Light {  // KHR_lights_punctual
  vec3 position;
  float inverseRadius2;  // 1 / radius^2; 0 without one
  vec3 intensity;        // colour times candela, or lux where it reaches everywhere
  uint type;             // kLight*: the files in shared/light, in the order of their names
  vec3 direction;        // from the light, unit
  float radius;          // metres: glTF's range; light is windowed to 0 there (shared/light.h). +inf without one
  float spotScale;       // spot cone: clamp(cos * spotScale + spotOffset, 0, 1)^2
  float spotOffset;
  float padding[2];
};
SH_CONST uint kLightBytes = 64u;

// --- shadows --------------------------------------------------------------------------------------------------------

// Which lights cast shadows differs from view to view, and they are few: a bit a light says whether it does in some
// view, and the set bits are numbered, as columns of a table with a row a view.
struct ShadowBits {  // of 32 lights
  uint lights;       // bit i: light 32 w + i of the frame
  uint before;       // how many lights before them have their bit set
};

struct LightShadow {  // of one light in one view
  uint first;         // its first map among the frame's
  uint maps;  // from there on: 6 are faces of a cube or cascades, more than one of a directional light cascades,
              // finest first; 0: it casts no shadows in this view
  uint sun;   // 1: the first directional light that casts some, which layouts may have a channel for
};

// One square tile of the shadow atlas, and what of the world it shows (render/shadow). With q = dot(row, (p, 1)) of a
// world position p for each of the three rows, the texel is (q.across, q.down) / w and the depth, from 0 to 1 and
// linear in metres, q.away * depthScale + depthOffset; w is q.away in a perspective map, 1 in an orthographic one.
struct ShadowMap {
  vec4 across;
  vec4 down;
  vec4 away;  // metres along the map's axis
  float depthScale;
  float depthOffset;
  float depthSlack;   // what the format and rounding may be off by, in depth
  float texel;        // metres across at w = 1
  float perspective;  // 1, or 0 for an orthographic map
  float lightSize;    // radius of the light in metres; for a directional one the tangent of half its angle
  uvec2 corner;       // the first texel of its tile in the atlas
  float size;         // its side, texels
  uint layer;         // of the atlas
  uint padding[2];
};
SH_CONST uint kShadowMapBytes = 96u;

// Above the local lights (point and spot) stands a tree of boxes, a heap without pointers: the children of node h are
// nodes kLightTreeWidth * (h + 1) + i, those of the root, which has no box, nodes i. From node
// FrameConstants::lightTreeLeaves on they are leaves: the l-th of them stands above the local lights kLightTreeWidth *
// l + i. Places without a node hold an empty box.
SH_CONST uint kLightTreeBits = 5u;  // at most 5
SH_CONST uint kLightTreeWidth = 1u << kLightTreeBits;

struct LightBox {  // 24 bytes: where lights reach, world space
  vec3 low;
  vec3 high;
};

// --- frame ----------------------------------------------------------------------------------------------------------

struct View {
  mat4x3 worldToView;  // rigid: view space is X right, Y away, Z up
  mat4x3 viewToWorld;
  Projection projection;  // jitter included
  vec3 eye;               // world
  vec2 size;              // pixels
  vec2 jitter;            // NDC: that part of the projection's principal point which moves the samples
  uint group;             // of the instances that alone it shows; 0: it shows all
  vec3 eyeLow;            // what `eye` leaves of the eye's position
  uint padding[2];
};
SH_CONST uint kViewBytes = 176u;

// Where a lens looks at one pixel. In a view through one, depth along a ray takes the place of depth along Y.
struct LensRay {
  vec3 direction;  // view space, unit; 0: it sees nothing there
  float depth;     // of the data output `depth`, a metre along the ray
};

struct FrameConstants {
  uint64_t views;         // View[viewCount]
  uint64_t instances;     // Instance[]
  uint64_t meshes;        // Mesh[]
  uint64_t materials;     // Material[]
  uint64_t textures;      // TextureRecord[], where compute shaders filter textures themselves; else 0
  uint64_t lights;        // Light[lightCount]: first the directional ones, then the local ones as the tree has them
  uint64_t lightTree;     // LightBox[]
  uint64_t shadowBits;    // ShadowBits[(lightCount + 31) / 32]
  uint64_t lightShadows;  // LightShadow[viewCount][shadowColumns]
  uint64_t shadowMaps;    // ShadowMap[]
  // A frame before and a frame after: arrays like `instances` and `views`, and the very same where nothing moves.
  uint64_t previousInstances;
  uint64_t nextInstances;
  uint64_t previousViews;  // without jitter
  uint64_t nextViews;
  uint64_t rays;  // of pictures through a lens, all views' LensRay[height + 2][width], from the row above on; else 0
  uint viewCount;
  uint lightCount;
  uint directionalLights;
  uint lightTreeLeaves;        // the first leaf's number
  uint shadowColumns;          // lights that cast shadows in some view
  float exposure;              // linear factor
  float environmentIntensity;  // 0: no environment
  float environmentCos;        // rotation about Z, see shared/environment.h
  float environmentSin;
  float environmentLevels;  // prefiltered levels, roughness 0 at level 0 and 1 at the last
  Fog fog;                  // of all surfaces, blended ones too, and of the background
  vec3 positionOffset;      // from device world space to that of the output `position`: a float, and the rest of a double
  vec3 positionOffsetLow;
};

SH_END

#if defined(__cplusplus)
static_assert(sizeof(latelight::shared::VertexPosition) == latelight::shared::kPositionBytes);
static_assert(sizeof(latelight::shared::VertexExtra) == 24);
static_assert(sizeof(latelight::shared::Mesh) == 96);
static_assert(sizeof(latelight::shared::TextureTransform) == 28);
static_assert(sizeof(latelight::shared::MaterialLayers) == 96);
static_assert(sizeof(latelight::shared::Material) == 80 + 19 * 28 + 19 * 4 + 96);
static_assert(sizeof(latelight::shared::Material) == latelight::shared::kMaterialBytes);
static_assert(sizeof(latelight::shared::LightBox) == 24);
// Where glsl/common.glsl finds their members.
static_assert(sizeof(latelight::shared::VertexAttributes) == latelight::shared::kAttributesBytes);
static_assert(offsetof(latelight::shared::VertexAttributes, uv0) == 28);
static_assert(sizeof(latelight::shared::View) == latelight::shared::kViewBytes);
static_assert(offsetof(latelight::shared::View, viewToWorld) == 48);
static_assert(offsetof(latelight::shared::View, projection) == 96);
static_assert(offsetof(latelight::shared::View, eye) == 124);
static_assert(offsetof(latelight::shared::View, jitter) == 144);
static_assert(offsetof(latelight::shared::View, eyeLow) == 156);
static_assert(sizeof(latelight::shared::Instance) == latelight::shared::kInstanceBytes);
static_assert(offsetof(latelight::shared::Instance, mesh) == 48);
static_assert(offsetof(latelight::shared::Instance, flags) == 64);
static_assert(sizeof(latelight::shared::Material) % 16 == 0);
static_assert(offsetof(latelight::shared::Material, emissive) == 16);
static_assert(offsetof(latelight::shared::Material, roughness) == 32);
static_assert(offsetof(latelight::shared::Material, specularColor) == 48);
static_assert(offsetof(latelight::shared::Material, f0) == 64);
static_assert(sizeof(latelight::shared::Light) == latelight::shared::kLightBytes);
static_assert(offsetof(latelight::shared::Light, intensity) == 16);
static_assert(offsetof(latelight::shared::Light, direction) == 32);
static_assert(offsetof(latelight::shared::Light, spotScale) == 48);
static_assert(sizeof(latelight::shared::ShadowMap) == latelight::shared::kShadowMapBytes);
static_assert(offsetof(latelight::shared::ShadowMap, depthScale) == 48);
static_assert(offsetof(latelight::shared::ShadowMap, perspective) == 64);
static_assert(offsetof(latelight::shared::ShadowMap, size) == 80);
#endif

#endif
