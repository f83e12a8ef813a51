// A scene as plain data: loaded from glTF files or built in, and uploaded by render/. No Vulkan.
//
// Object space is the file's own. World space is the renderer's (X right, Y away, Z up), so every world transform of a
// glTF scene includes toWorldFromGltf(). Placements are doubles, so that a scene may lie anywhere on a planet; vertices are
// floats in object space. Lengths in meters, angles in radians, colors linear Rec.709.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/memory.h"
#include "scene/animation.h"
#include "scene/edit_log.h"
#include "scene/ids.h"
#include "scene/lens.h"
#include "shared/types.h"

namespace latelight::scene {

using glm::dmat4;
using glm::dvec3;
using glm::mat4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

// Pixel storage that is never zero-filled, and that scenes share where their pictures are the same (texture.h). RGBA, 8
// bits a channel, all mip levels one after the other, level 0 first, rows from the top, each level max(1, size >>
// level) pixels.
struct Texture {
  std::string name;
  uint32_t width = 0, height = 0;
  uint32_t levels = 0;  // the full chain: floor(log2(max(width, height))) + 1
  bool srgb = false;    // colour channels are sRGB-encoded (mip levels were averaged in linear light); alpha is linear
  std::shared_ptr<std::byte[]> pixels;
  bool removed = false;  // a gap that the next added texture fills (edit.h)
  size_t bytes() const;  // of all levels
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
  bool removed = false;  // a gap that the next added material fills (edit.h)
};

// glTF's defaults: nothing lies over the surface.
shared::MaterialLayers noLayers();
// kLayer* of those that show. An unlit surface has none.
uint32_t layersOf(const shared::Material& material);
// kMaterialLayered and kMaterialTransmissive, as the layers have it.
uint32_t layerFlags(const shared::Material& material);

// One glTF primitive: triangles only (strips and fans unrolled), indices always present, normals always present.
struct Mesh {
  std::string name;
  std::vector<vec3> positions;
  std::vector<shared::VertexAttributes> attributes;
  std::vector<shared::VertexExtra> extras;  // empty, or one per vertex
  std::vector<uint32_t> indices;            // 3 per triangle, counter-clockwise front faces
  vec3 boundsMin{0}, boundsMax{0};          // object space
  float longestEdge = 0;                    // of its triangles, object space
  // The deformation of its vertices, or null. With one, positions, normals and tangents above are those at rest.
  std::shared_ptr<const Deformation> deformation;
  bool removed = false;    // a gap that the next added mesh fills (edit.h)
  uint64_t bytes() const;  // of its arrays
};

// A mesh placed in the world.
struct Instance {
  uint32_t mesh = 0;
  uint32_t material = 0;
  uint32_t node = 0;  // index into Scene::nodes
  // Stable and never 0 (ids.h). `id` is the node's, or that of the group it is in; without groups each copy made by
  // EXT_mesh_gpu_instancing has its own. `part` is unique to the instance.
  uint32_t id = 0, part = 0;
  uint32_t primitive = 0;  // of the node's mesh
  int copy = -1;           // its number among the node's, by EXT_mesh_gpu_instancing; -1: no copies
  dmat4 toWorld{1};
  bool posed = false;    // skinned: the joints move its vertices, and its node does not (3.7.3.3)
  bool placed = false;   // its transform was set by an edit (edit.h): no animation moves it
  bool removed = false;  // a gap that the next added instance fills (edit.h)
  bool hidden = false;   // at rest; an animation shows it
};

struct Node {
  std::string name;
  std::string path;  // "/Root/Arm/Hand": names from the root; unnamed nodes are "node<index>", twins get "#2", "#3"...
  std::string mesh;  // the name of its mesh; empty: it has none
  uint32_t id = 0;   // stable, unique in the scene, never 0; in a group, that of the topmost node
  uint32_t added = 0;  // instances that an edit put there (edit.h): it is removed with the last one
  int parent = -1;
  dmat4 local{1};    // the file's own frame
  dmat4 toWorld{1};  // the renderer's world
};

// The default near plane of a camera, metres, in a scene measured in metres. It costs no precision: see framing.h.
inline constexpr float kNearClip = 0x1p-40f;

struct Camera {
  std::string name;
  dmat4 toWorld{1};  // camera space is the renderer's view space: X right, Y away, Z up
  bool orthographic = false;
  float verticalFov = 0.8f;  // full angle, radians (perspective)
  float yHalf = 1;           // half the vertical extent, metres (orthographic)
  // Width / height of the camera's own frame. Pictures show all of it: a narrower one shows more above and below, a
  // wider one more at the sides. Without one, every picture keeps the vertical extent.
  std::optional<float> aspect;
  float nearClip = kNearClip;
  float farClip = std::numeric_limits<float>::infinity();
  vec2 principal{0};         // principal point offset, NDC: 0 is the picture's centre
  std::optional<Lens> lens;  // instead of the field of view and the principal point
  int node = -1;             // that it follows, index into Scene::nodes
  uint32_t group = 0;        // of the instances that alone it shows (render::Moment::groups); 0: it shows all
};

extern const uint32_t kPointLight;  // kLightPoint: this header need not change with every type that is added

struct Light {
  std::string name;
  uint32_t type = kPointLight;  // kLight* (shared/light.h)
  vec3 color{1};
  float intensity = 1;  // candela; of directional ones lux
  std::optional<float> range;
  float innerCone = 0, outerCone = 0.785398163f;  // half angles
  dvec3 position{0};                              // world
  vec3 direction{0, 0, -1};                       // world, unit, from the light
  int node = -1;                                  // that it follows, index into Scene::nodes
  // Source radius in metres; for a directional light its angular diameter in radians. 0: unknown. Geometry nearer to a
  // point or spot light than that is its own body and casts no shadow.
  float size = 0;
  std::optional<bool> castShadow;  // true: before all lights without this; false: never
  bool removed = false;            // a gap that the next added light fills (edit.h)
  bool hidden = false;             // at rest; an animation shows it
  bool operator==(const Light&) const = default;
};

// Slots of removed elements. How often a slot was emptied distinguishes its current element from earlier ones.
struct Gaps {
  std::vector<uint32_t> free;
  std::vector<uint32_t> emptied;  // by slot; 0 for those beyond its end
  uint32_t generation(uint32_t place) const { return place < emptied.size() ? emptied[place] : 0; }
};

// Changes since the scene was created (edit.h).
struct SceneEdits {
  EditLog meshes, materials, textures, instances, lights;
  Gaps meshGaps, materialGaps, textureGaps, instanceGaps, lightGaps;
  std::vector<uint32_t> freeNodes;  // of instances that were added and removed
  // Ids of nodes and of instances, so that added ones get unused ids; filled when the first one is added.
  struct KnownIds {
    UniqueIds nodes, parts, materials;
  };
  std::optional<KnownIds> ids;
  uint32_t twins = 1;  // distinguishes elements added under the same name
};

struct Environment;

struct Scene {
  std::string name;                          // the file's name without folder and extension, or the built-in's
  std::string source;                        // what the user named
  std::vector<std::filesystem::path> files;  // that were read: this one and those it names
  bool yUp = true;  // the file's own frame is glTF's (Y up, camera along -Z); else the renderer's Z up
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Instance> instances;
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  std::vector<std::string> variants;               // KHR_materials_variants
  Rig rig;                                         // the moving parts; everything above is at rest
  std::shared_ptr<const Environment> environment;  // of its own, or null
  SceneEdits edits;
  MemoryClaim memory;  // its share of the machine's memory

  uint64_t triangleCount() const;  // of all instances
};

struct Bounds {
  dvec3 min{std::numeric_limits<double>::infinity()}, max{-std::numeric_limits<double>::infinity()};
  bool empty() const { return min.x > max.x; }
  dvec3 centre() const { return (min + max) * 0.5; }
  double radius() const { return empty() ? 0.0 : glm::length(max - min) * 0.5; }
};
Bounds worldBounds(const Scene&);
// Computes its bounds and its longest edge; zero where it has no positions.
void findBounds(Mesh& mesh);
// A point, in object space, around which a device has the vertices: 0, or near them where they lie far from 0. Subtracting it
// is exact. Vertices that deform have 0.
vec3 vertexOrigin(const Mesh& mesh);

// glTF's frame (X right, Y up, Z towards the viewer) to the renderer's (X right, Y away, Z up), and back.
dmat4 toWorldFromGltf();
dmat4 toGltfFromWorld();

// Applies a node's transform in the file's own frame to its camera or light. False where the node's scale is zero: then
// the camera keeps its position and looks along -Z.
bool placeCamera(Camera& camera, const glm::dmat4& world);
void placeLight(Light& light, const glm::dmat4& world);

// Whole subtrees of nodes under one id: that of their topmost node. At most one of the two.
struct IdGrouping {
  // Nodes deeper than this have the id of their ancestor at this depth. Roots are at depth 0, their children at 1; a
  // copy by EXT_mesh_gpu_instancing is one level deeper than its node.
  std::optional<uint32_t> depth;
  // Names or paths of nodes; a name selects every node that has it. Each one's subtree has its id, except for the part
  // below another of them.
  std::vector<std::string> nodes;
};

struct LoadOptions {
  std::string variant;  // KHR_materials_variants by name; empty: the file's default
  // Folders that the file may read in addition to its own and those below; base/enclosure.h.
  std::vector<std::string> allowOutside;
  IdGrouping ids{};
  bool textures = true;  // false: none are decoded, for what asks for the geometry alone
  // Bit i: textures in slot i of materials (shared::kTexture*) are wanted; the other slots are left empty. Where alpha
  // decides what shows, the base colour is always there.
  uint32_t textureSlots = ~0u;
};

// A .gltf or .glb file, or "builtin:NAME[,key=value...]". Throws Error(BadInput) naming the file and what is wrong, and
// Error(Usage) for options that don't fit the scene.
Scene load(const std::string& source, const LoadOptions& options = {});

Scene loadGltf(const std::filesystem::path& path, const LoadOptions& options);  // gltf.cpp
Scene makeBuiltin(const std::string& name, uint32_t textureSlots = ~0u);        // builtin.cpp: what follows "builtin:"

}  // namespace latelight::scene
