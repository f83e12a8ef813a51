// A scene as plain data: loaded from glTF files or built in, and uploaded by render/. No Vulkan.
//
// Object space is the file's own. World space is the renderer's (X right, Y away, Z up), so every world transform of a
// glTF scene includes toWorldFromGltf(). Transforms are doubles, so that a scene may lie anywhere on a planet; vertices
// are floats in object space. Lengths are in meters, angles in radians, colors in linear Rec.709.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/memory.h"
#include "scene/animation.h"
#include "scene/aperture.h"
#include "scene/edit_log.h"
#include "scene/ids.h"
#include "scene/lens.h"
#include "scene/tangents.h"
#include "shared/types.h"

namespace latelight::scene {

using glm::dmat4;
using glm::dvec3;
using glm::mat3;
using glm::mat4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

// A texture, whose pixel storage is never zero-filled and is shared by scenes with the same images (texture.h). Pixels
// are RGBA with 8 bits per channel, all mip levels consecutively, level 0 first, rows from the top. Each level has
// max(1, size >> level) pixels per side.
struct Texture {
  std::string name;
  uint32_t width = 0, height = 0;
  uint32_t levels = 0;  // the full chain: floor(log2(max(width, height))) + 1
  bool srgb = false;    // color channels are sRGB-encoded (mip levels are averaged in linear light); alpha is linear
  std::shared_ptr<std::byte[]> pixels;
  bool removed = false;  // a free slot that the next added texture reuses (edit.h)
  size_t bytes() const;  // total of all levels
};

enum class Wrap : uint8_t { Repeat, Mirror, Clamp };
enum class Filter : uint8_t { Nearest, Linear };
enum class MipFilter : uint8_t { None, Nearest, Linear };
struct Sampler {
  Wrap wrapU = Wrap::Repeat, wrapV = Wrap::Repeat;
  Filter magnify = Filter::Linear, minify = Filter::Linear;
  MipFilter mip = MipFilter::Linear;
  bool operator==(const Sampler&) const = default;
};

struct TextureSlot {
  int texture = -1;  // index into Scene::textures; -1: none
  Sampler sampler;
};

struct Material {
  std::string name;
  shared::Material data{};  // as shaders read it
  TextureSlot slots[shared::kTextureCount];
  bool removed = false;  // a free slot that the next added material reuses (edit.h)
};

// glTF's defaults: no coats over the surface.
shared::MaterialLayers noLayers();
// Returns kLayer* of the coats that have an effect. An unlit surface has none.
uint32_t layersOf(const shared::Material& material);
// Returns the flags kMaterialLayered and kMaterialTransmissive that follow from the coats.
uint32_t layerFlags(const shared::Material& material);

struct MorphableMesh;

// One glTF primitive: triangles only (strips and fans unrolled), indices always present, normals always present.
struct Mesh {
  std::string name;
  std::vector<vec3> positions;
  std::vector<shared::VertexAttributes> attributes;
  std::vector<shared::VertexExtra> extras;   // empty, or one per vertex
  std::vector<uint32_t> indices;             // 3 per triangle, counter-clockwise front faces
  vec3 boundsMin{0}, boundsMax{0};           // object space
  float longestEdge = 0;                     // maximum over its triangles, in object space
  std::optional<TangentSpace> tangentSpace;  // set if the loader of glTF has generated its tangents, for this space
  // The deformation of its vertices, or null. If it is set, the positions, normals and tangents above are those at
  // rest.
  std::shared_ptr<const Deformation> deformation;
  // The same mesh with the morph targets that its file does not animate, or null (LoadOptions::morphTargets).
  std::shared_ptr<const MorphableMesh> morphable;
  bool removed = false;    // a free slot that the next added mesh reuses (edit.h)
  uint64_t bytes() const;  // total of its arrays
};

struct MorphableMesh {
  Mesh mesh;                   // in its rest pose, with a deformation that has no node with weights yet
  std::vector<float> weights;  // at rest; those of further targets are 0
};

// A mesh placed in the world.
struct Instance {
  uint32_t mesh = 0;
  uint32_t material = 0;
  uint32_t node = 0;  // index into Scene::nodes
  // Stable and never 0 (ids.h). `id` is the node's id, or that of its group; without groups, each copy by
  // EXT_mesh_gpu_instancing has its own. `part` is unique to the instance.
  uint32_t id = 0, part = 0;
  uint32_t primitive = 0;  // index among the primitives of the node's mesh
  int copy = -1;           // index among the node's copies by EXT_mesh_gpu_instancing; -1: no copies
  dmat4 toWorld{1};
  bool posed = false;    // skinned: the joints move its vertices, its node does not (3.7.3.3)
  bool placed = false;   // an edit has set its transform (edit.h), and no animation moves it
  bool removed = false;  // a free slot that the next added instance reuses (edit.h)
  bool hidden = false;   // at rest; an animation may make it visible
};

struct Node {
  std::string name;
  std::string path;    // names from the root ("/Root/Hand"); unnamed nodes are "node<index>", duplicates get "#2", ...
  std::string mesh;    // name of its mesh; empty if it has none
  uint32_t id = 0;     // stable, unique in the scene, never 0; in a group, that of the topmost node
  uint32_t added = 0;  // number of instances that an edit added to it (edit.h); the node is removed with the last one
  bool followed = false;  // an edit has added a node, skin, light or camera that follows it
  int parent = -1;
  dmat4 local{1};    // in the file's own frame
  dmat4 toWorld{1};  // in the renderer's world
};

// The default near plane of a camera in meters, in a scene measured in meters. It costs no precision: see framing.h.
inline constexpr float kNearClip = 0x1p-40f;

struct Camera {
  std::string name;
  dmat4 toWorld{1};  // camera space is the renderer's view space: X right, Y away, Z up
  bool orthographic = false;
  float verticalFov = 0.8f;  // full angle in radians (perspective)
  float yHalf = 1;           // half the vertical extent in meters (orthographic)
  // Width / height of the camera's own frame. Images always contain all of it: a narrower image shows more above and
  // below, a wider one more at the sides. If unset, every image keeps the vertical extent.
  std::optional<float> aspect;
  float nearClip = kNearClip;
  float farClip = std::numeric_limits<float>::infinity();
  vec2 principal{0};                    // principal point offset in NDC; 0 is the image's center
  std::optional<Lens> lens;             // replaces the field of view and the principal point
  std::optional<Aperture> aperture;     // replaces the settings' aperture
  std::optional<double> focusDistance;  // in meters; replaces the settings' distance
  uint64_t noiseSeed = 0;               // the sensor's noise differs between seeds
  int node = -1;                        // node that the camera follows, index into Scene::nodes; -1: none
  uint32_t group = 0;                   // renders only the instances of this group (render::SceneState::groups); 0: all
  uint32_t world = 0;                   // the world that it shows (render::SceneState::worlds); 0 without worlds
  bool operator==(const Camera&) const = default;
};

extern const uint32_t kPointLight;  // kLightPoint; external, so that this header need not change with added types

struct Light {
  std::string name;
  uint32_t type = kPointLight;  // kLight* (shared/light.h)
  vec3 color{1};
  float intensity = 1;  // candela; lux for directional lights; nits (candela per square meter) for area lights
  std::optional<float> range;
  float innerCone = 0, outerCone = 0.785398163f;  // half angles
  dvec3 position{0};                              // in world space
  vec3 direction{0, 0, -1};                       // in world space, unit length, from the light
  int node = -1;                                  // node that the light follows, index into Scene::nodes; -1: none
  // Source radius in meters; for a directional light its angular diameter in radians. 0: unknown. Geometry closer to a
  // point or spot light than this radius is the light's own body and casts no shadow.
  float size = 0;
  // Area lights (shared/area_light.h): `size` is the radius of a disk, sphere or tube, in meters.
  float width = 1, height = 1;     // of a rectangle along X and Y, in meters
  float length = 1;                // of a tube along X, in meters
  bool twoSided = false;           // rectangles and disks: both sides emit
  mat3 axes{1};                    // the linear part of the transform from the light's space to world space
  std::optional<bool> castShadow;  // true: has precedence over lights without this value; false: never
  bool removed = false;            // a free slot that the next added light reuses (edit.h)
  bool hidden = false;             // at rest; an animation may make it visible
  bool operator==(const Light&) const = default;
};

// Slots of removed elements. The number of times that a slot was emptied distinguishes its current element from earlier
// ones.
struct Gaps {
  std::vector<uint32_t> free;
  std::vector<uint32_t> emptied;  // per slot; 0 for slots beyond its end
  uint32_t generation(uint32_t place) const { return place < emptied.size() ? emptied[place] : 0; }
};

// Changes since the scene was created (edit.h).
struct SceneEdits {
  EditLog meshes, materials, textures, instances, lights;
  Gaps meshGaps, materialGaps, textureGaps, instanceGaps, lightGaps;
  std::vector<uint32_t> freeNodes;  // nodes of instances that were added and removed
  // Ids of nodes and of instances, so that added elements get unused ids. Filled when the first element is added.
  struct KnownIds {
    UniqueNames nodes, materials;
    UniqueIds parts;
  };
  std::optional<KnownIds> ids;
};

struct Environment;

// An added node that copies part of the scene, at rest. Skins deform the copies of their meshes, too.
struct NodeCopy {
  int node = -1;          // the node that is copied with all nodes below it; -1: several
  dmat4 displacement{1};  // in the world, from the original to the copy; it does not mirror
  dvec3 scaleSigns{1};    // of the original of the first part (objects.h)
};

// The copies of a node by EXT_mesh_gpu_instancing as its file states them: transforms relative to the node.
struct FileCopies {
  std::vector<glm::vec4> translations, rotations, scales;  // one per copy, or empty: those of the identity
};
// Return the transform of a copy as the file states it, and as a matrix.
RigNode statedTransform(const FileCopies& copies, size_t copy);
dmat4 nodeFromCopy(const FileCopies& copies, size_t copy);

// The material of an instance in a variant that changes it (KHR_materials_variants).
struct VariantMaterial {
  uint32_t variant = 0;  // index into Scene::variants
  uint32_t instance = 0, material = 0;
};

struct Scene {
  std::string name;                          // the file's name without folder and extension, or the built-in scene's
  std::string source;                        // as the user specified it
  std::vector<std::filesystem::path> files;  // all files read: this one and those to which it refers
  bool yUp = true;  // the file's own frame is glTF's (Y up, camera along -Z); otherwise the renderer's (Z up)
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Instance> instances;
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  std::vector<std::string> variants;              // KHR_materials_variants
  std::vector<VariantMaterial> variantMaterials;  // without those of removed materials and of reused instances
  Rig rig;                                        // animation data; all members above are at rest
  // The nodes of a glTF file without a rig as the file defines them, except for their parents: element i is that of
  // `nodes`. Edits that extend the rig to all nodes (rig_edit.h) move them there.
  std::vector<RigNode> fileNodes;
  std::map<uint32_t, FileCopies> fileCopies;       // by node of the file
  std::shared_ptr<const Environment> environment;  // the file's own, or null
  std::map<uint32_t, NodeCopy> nodeCopies;         // by added node
  SceneEdits edits;
  MemoryClaim memory;  // memory that the scene's data claim (base/memory.h)

  uint64_t triangleCount() const;  // total over all instances
};

struct Bounds {
  dvec3 min{std::numeric_limits<double>::infinity()}, max{-std::numeric_limits<double>::infinity()};
  bool empty() const { return min.x > max.x; }
  dvec3 center() const { return (min + max) * 0.5; }
  double radius() const { return empty() ? 0.0 : glm::length(max - min) * 0.5; }
};
Bounds worldBounds(const Scene&);  // around the transformed boxes of the meshes of all visible instances, at rest
// Returns the lowest height of any vertex along Z of world space, at rest; 0 if nothing is shown.
double lowestPoint(const Scene& scene);
// Extends `bounds` by those of an instance with this transform.
void addBounds(const Scene& scene, const Instance& instance, const dmat4& toWorld, Bounds& bounds);
// Extends `bounds` by those of a box with this transform.
void addBox(vec3 low, vec3 high, const dmat4& toWorld, Bounds& bounds);
// Computes the mesh's bounds and its longest edge; they are zero if it has no positions.
void findBounds(Mesh& mesh);
// Returns the object-space point relative to which a device stores the vertices: 0, or a point near the vertices if
// they are far from 0. Subtracting it is exact. It is 0 for deformed vertices.
vec3 vertexOrigin(const Mesh& mesh);

// Transforms from glTF's frame (X right, Y up, Z towards the viewer) to the renderer's (X right, Y away, Z up), and
// back.
dmat4 toWorldFromGltf();
dmat4 toGltfFromWorld();

// Apply a node's transform in the file's own frame to its camera or light. placeCamera() returns false if the node's
// scale is zero; the camera then keeps its position and looks along -Z.
bool placeCamera(Camera& camera, const glm::dmat4& world);
void placeLight(Light& light, const glm::dmat4& world);

// Groups full subtrees of nodes under the id of their topmost node. At most one of the two members may be set.
struct IdGrouping {
  // Nodes deeper than this get the id of their ancestor at this depth. Roots are at depth 0, their children at 1. A
  // copy by EXT_mesh_gpu_instancing is one level deeper than its node.
  std::optional<uint32_t> depth;
  // Names or paths of nodes; a name selects all nodes of that name. The subtree of each gets its id, except for the
  // part below another selected node.
  std::vector<std::string> nodes;
};

struct LoadOptions {
  std::string variant;  // name of a variant (KHR_materials_variants); empty: the file's default
  // Folders that the file may read in addition to its own folder and its subfolders (base/allowed_folders.h).
  std::vector<std::string> allowOutside;
  IdGrouping ids{};
  // For OBJ, PLY and STL files, which do not state them (mesh_files/source.h); empty: the format's default.
  std::string unit;                  // unit of length: "mm", "cm", "m", "in" or "ft"
  std::string upAxis;                // "y" or "z"
  std::optional<float> pointRadius;  // radius of the spheres that stand for the points of a PLY file, in meters
  bool textures = true;              // false: no textures are decoded, for callers that require only geometry
  // Bit i requests the textures in slot i of materials (shared::kTexture*); other slots stay empty. The base color is
  // always loaded if alpha affects visibility.
  uint32_t textureSlots = ~0u;
  // Generates the tangents that a normal map on the first texture coordinates requires also for meshes whose materials
  // require none, for callers that add normal maps.
  bool tangents = false;
  // Loads morph targets that no animation of the file moves (Mesh::morphable), for callers that add animations or
  // export the scene.
  bool morphTargets = false;
};

}  // namespace latelight::scene
