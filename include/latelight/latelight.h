// Latelight's public C++ API. It contains no Vulkan types, and the library exports nothing else.
//
//   latelight::Scene scene("helmet.glb");
//   latelight::Renderer renderer(scene);
//   latelight::Options options;
//   options.aovs = {"depth", "normal", "id"};
//   latelight::Frame frame = renderer.render(scene.defaultCamera(16.0f / 9), options);
//   // frame.rgba, frame.aovs.at("depth").values, ...
//
// Units are meters and degrees. Colors are linear Rec.709, except Frame::rgba. Poses and positions are in the scene
// file's own frame (glTF: right-handed, Y up). Every function may throw latelight::Error.
#pragma once

#include <latelight/error.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace latelight {

// The library's version, such as "0.1.0".
LATELIGHT_API const char* version();

// Sends the warnings of this process to a function instead of standard error: each is one sentence, without a line
// break and safe to print. The function receives every warning, whereas standard error receives each sentence once. A
// function that does nothing silences warnings, and an empty one restores the default. Any thread may call it, also
// several at a time. It must not throw, and of the library it may call only setWarningHandler().
LATELIGHT_API void setWarningHandler(std::function<void(const std::string& sentence)> handler);

// Limits the machine's memory, in bytes, that this process may use for scenes, pictures and devices that run on the
// CPU. An operation that would exceed the limit throws Error(OutOfMemory) before it allocates. 0, the default, is three
// quarters of the free memory.
LATELIGHT_API void setMemoryLimit(uint64_t bytes);

enum class LensModel {
  Pinhole,          // any focal lengths and principal point, no distortion
  OpenCv,           // OpenCV's radial and tangential distortion: k1 k2 p1 p2 k3 k4 k5 k6
  Fisheye,          // Kannala and Brandt's model, as in OpenCV: k1 k2 k3 k4, of the angle to the axis
  Equirectangular,  // all directions: the axis at the center, longitude to the right, latitude up
  CubeMap,          // six faces side by side: +X -X +Y -Y +Z -Z of the camera's frame
  FTheta,  // NVIDIA's f-theta: the angle to the axis is k0 + k1 r + ... + k5 r^5, r in units of fx and fy pixels
};

// The rays of a camera (docs/lenses.md), calibrated for images of width x height pixels; an image of another size is
// the same image, scaled. Pixel centers are at half-integers. OpenCV's cx and cy count from the first pixel's center,
// so add 0.5 to them.
struct Lens {
  LensModel model = LensModel::Pinhole;
  double width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels; unused by equirectangular images and cube maps
  std::array<double, 8> distortion{};     // the coefficients of the model, then zeros
};

struct Camera {
  std::string name;
  // Transform from the camera frame to the scene file's frame, row-major: a rotation and a translation. The camera
  // frame is OpenCV's: X right, Y down, Z forward.
  std::array<double, 16> cameraToWorld{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  bool orthographic = false;  // requires a finite far plane, so set `farClip`, too
  float verticalFov = 40;     // degrees, full angle; unused by orthographic cameras
  float halfHeight = 1;       // meters, above 0; only of orthographic cameras
  // Width / height of the camera's own frame. Images of another aspect show all of this frame, unless
  // Options::cameraFit is "vertical". Without an aspect, or with a lens, every image has the vertical extent above.
  std::optional<float> aspect{};
  // In meters. Depth precision does not depend on the near plane, so the default is 2^-40. Increase it only to clip
  // near geometry.
  float nearClip = 9.09494702e-13f;  // above 0, except of orthographic cameras
  float farClip = std::numeric_limits<float>::infinity();
  float principalX = 0, principalY = 0;   // offset of the principal point from the center, in half widths and half
                                          // heights, y up
  std::optional<Lens> lens{};             // replaces the field of view, the principal point and, if it bends rays, the
                                          // near and far planes
  std::string aperture{};                 // "pinhole", "f/2.8" or a radius in meters; empty: Options::aperture
  std::optional<double> focusDistance{};  // meters, above 0; empty: Options::focusDistance
  std::optional<double> shutter{};        // exposure time in seconds, 0 to 10000; empty: Options::shutter
  std::optional<double> readout{};        // of a rolling shutter, seconds, -10000 to 10000; empty: Options::readout
  std::optional<double> exposure{};       // in EV, -60 to 60; empty: that of Options::exposure. If that is metered,
                                          // this is its compensation
  uint32_t noiseSeed = 0;                 // cameras of different seeds have different noise, besides Options::noiseSeed
};

struct Animation {
  std::string name;
  float duration = 0;  // seconds
};

struct SceneOptions {
  std::string materialVariant{};            // name of a KHR_materials_variants variant; empty: the file's default
  std::vector<std::string> allowOutside{};  // folders that the scene may read files from, in addition to its own folder
                                            // and folders below it
  // Groups whole subtrees of nodes under one "id". Set at most one of the two. With idDepth, deeper nodes have the id
  // of their ancestor at that depth (roots are at depth 0). With idNodes, a list of names or paths, each listed node's
  // subtree has that node's id, except for the subtrees of other listed nodes below it. A name that no node has throws
  // Error(Usage).
  std::optional<uint32_t> idDepth{};
  std::vector<std::string> idNodes{};
  // For OBJ, PLY and STL files, which do not state them. Other scenes throw Error(Usage).
  std::string unit{};                  // unit of length: "mm", "cm", "m", "in" or "ft"; empty: "m"
  std::string upAxis{};                // "y" or "z"; empty: "y" for OBJ, "z" for PLY and STL
  std::optional<float> pointRadius{};  // radius in meters of the spheres that stand for the points of a PLY file
};

// --- scene elements, which can be read and edited -------------------------------------------------------------------

// Identifies an element of a scene. Handles are small values that can be copied freely. A handle to a removed element
// is rejected with Error(Usage), even if another element has reused its slot. A handle from another scene is rejected
// likewise.
template <typename Element>
struct Handle {
  uint32_t scene = 0;  // 0: an empty handle
  uint32_t index = 0, generation = 0;
  bool operator==(const Handle&) const = default;
};

// Row-major transform from object space to the scene file's frame. The last row is 0 0 0 1.
using Transform = std::array<double, 16>;

enum class AlphaMode { Opaque, Mask, Blend };

// glTF's metallic-roughness material. Factors multiply the material's textures.
struct Material {
  std::string name;                            // set by addMaterial(); setMaterial() does not change it
  uint32_t id = 0;                             // value of the output "material"; assigned by the scene
  std::array<float, 4> baseColor{1, 1, 1, 1};  // at least 0; may be above 1, which files cannot store: exports limit it
  float metallic = 1, roughness = 1;           // 0 to 1
  std::array<float, 3> emissive{0, 0, 0};      // radiance; may be above 1
  AlphaMode alphaMode = AlphaMode::Opaque;
  float alphaCutoff = 0.5f;  // with AlphaMode::Mask: surfaces with less alpha are discarded
  bool doubleSided = false, unlit = false;
  float normalScale = 1;                        // factor of the normal map's slopes
  float occlusionStrength = 1;                  // 0 to 1
  float specular = 1;                           // of KHR_materials_specular, 0 to 1
  std::array<float, 3> specularColor{1, 1, 1};  // at least 0; may be above 1
  float f0 = 0.04f;  // reflectance of a dielectric at normal incidence: ((ior - 1) / (ior + 1))^2
  // Coats and transmission of the KHR_materials_* extensions. Strengths, roughness and colors are from 0 to 1. A
  // strength of 0 disables the layer.
  float clearcoat = 0, clearcoatRoughness = 0;
  float clearcoatNormalScale = 1;            // factor of the slopes of the clearcoat's own normal map
  std::array<float, 3> sheenColor{0, 0, 0};  // black: no sheen
  float sheenRoughness = 0;
  float anisotropy = 0, anisotropyRotation = 0;  // rotation in degrees, counter-clockwise from the tangent
  float iridescence = 0, iridescenceIor = 1.3f;  // index of refraction of the film, at least 1
  float iridescenceThinnest = 100, iridescenceThickest = 400;  // nanometers, where the texture is 0 and 1
  float transmission = 0;
  float thickness = 0;                                                 // meters in object space; 0: thin-walled
  std::array<float, 3> attenuationColor{1, 1, 1};                      // color of white light after that distance
  float attenuationDistance = std::numeric_limits<float>::infinity();  // meters; above 0
  float dispersion = 0;                                                // 20 / the Abbe number
  float diffuseTransmission = 0;
  std::array<float, 3> diffuseTransmissionColor{1, 1, 1};
};

enum class TextureSlot {
  BaseColor,
  MetallicRoughness,
  Normal,
  Occlusion,
  Emissive,
  Specular,
  SpecularColor,
  Clearcoat,
  ClearcoatRoughness,
  ClearcoatNormal,
  SheenColor,
  SheenRoughness,
  Anisotropy,
  Iridescence,
  IridescenceThickness,
  Transmission,
  Thickness,
  DiffuseTransmission,
  DiffuseTransmissionColor
};
enum class Wrap { Repeat, Mirror, Clamp };

struct Texture {
  std::string name;
  uint32_t width = 0, height = 0;
  bool srgb = true;  // colors are sRGB-encoded; alpha never is
};

// Pixels of a texture that a program creates: RGBA, 8 bits per channel, straight alpha, rows from the top. Width and
// height must be above 0, and `rgba` must have 4 width height bytes.
struct TextureData {
  std::string name;
  uint32_t width = 0, height = 0;
  bool srgb = true;  // true for base color and emission; false for normals, roughness and other data
  std::vector<uint8_t> rgba;
};

// How a material samples a texture. Channels are those of glTF: roughness is green, metalness is blue.
struct TextureUse {
  Handle<Texture> texture;
  Wrap wrapU = Wrap::Repeat, wrapV = Wrap::Repeat;
  bool smooth = true;  // linear filtering with mip levels; otherwise the nearest texel
  uint32_t uvSet = 0;  // 0 or 1
};

// A light of KHR_lights_punctual, or an area light: a rectangle, a disk, a sphere or a closed tube that emits uniform
// radiance. Rectangles and disks emit toward `direction`, and a tube extends perpendicularly to `direction` and `up`.
struct Light {
  std::string name;
  std::string type = "point";                // a type that `latelight list lights` shows
  std::array<double, 3> position{0, 0, 0};   // unused by directional lights
  std::array<float, 3> direction{0, 0, -1};  // direction of emission, of any length above 0; unused by point lights
  std::array<float, 3> color{1, 1, 1};
  float intensity = 1;                   // candela; lux for directional lights; nits (cd/m^2) for area lights
  std::optional<float> range;            // meters; empty: unbounded
  double innerCone = 0, outerCone = 45;  // half angles of spot lights, degrees
  double size = 0;                       // radius, meters; angular diameter in degrees for directional lights
  std::optional<bool> castShadow;        // true: has priority over lights without a value; false: never casts shadows
  // Area lights only. Disks, spheres and tubes require a `size` above 0.
  double width = 1, height = 1;         // of a rect, meters; the height is along `up`
  double length = 1;                    // of a tube, meters
  bool twoSided = false;                // rect, disk: both sides emit
  std::array<float, 3> up{0, 1, 0};     // any length above 0; if it is parallel to `direction`, another is chosen
  std::array<float, 3> scale{1, 1, 1};  // of the shape along its own axes: sideways, `up`, and against `direction`
};

// A triangle mesh in its rest pose.
struct Mesh {
  std::string name;
  uint64_t vertices = 0, triangles = 0;
  std::array<float, 3> boundsMin{}, boundsMax{};  // object space
  bool deforms = false;                           // a skin or morph targets move its vertices
};

// A morph target of a mesh: what it adds to the vertices, times a weight. Each array is empty or has one element per
// position of the mesh; normals and tangents require those of the mesh.
struct MorphTarget {
  std::vector<std::array<float, 3>> positions, normals, tangents;
};

// Nodes that deform meshes, by linear blend skinning as glTF defines it (3.7.3).
struct Skin {
  std::vector<std::string> joints;     // paths of nodes
  std::vector<Transform> inverseBind;  // one per joint: from the object space of the meshes to the joint; empty:
                                       // identities
};

// A mesh that a program creates, in object space. Positions are required. The other attributes are each empty or have
// one value per position; all values must be finite.
struct MeshData {
  std::string name;
  std::vector<std::array<float, 3>> positions;
  std::vector<uint32_t> indices;               // three per triangle, front faces counter-clockwise; empty: every three
                                               // positions are one triangle
  std::vector<std::array<float, 3>> normals;   // empty: flat normals of the triangles, which then share no vertices
  std::vector<std::array<float, 4>> tangents;  // with the bitangent's sign in w; empty: computed from uv, if there is
                                               // any
  std::vector<std::array<float, 2>> uv, uv1;   // first and second set, v down
  std::vector<std::array<float, 4>> colors;    // linear, 0 to 1; multiplies the base color
  std::vector<MorphTarget> targets;            // the node that shows the mesh has their weights (NodeData)
  // With a skin: indices into its joints, and their weights, which are scaled to a sum of 1 per vertex. Each vertex has
  // the same number of them, consecutively. Joints move such a mesh, the nodes that show it do not.
  std::optional<Handle<Skin>> skin{};
  std::vector<uint32_t> joints;
  std::vector<float> jointWeights;
};

// A node of the file, or of an added instance.
struct Node {
  std::string path;                                                     // "/Root/Arm/Hand"
  std::string parent;                                                   // path of the parent node; empty: the node is a
                                                                        // root
  std::string mesh;                                                     // name of the mesh; empty: the node has no mesh
  Transform transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  // to the scene file's frame, in the rest pose
  uint32_t id = 0;                                                      // value of the output "id"
};

struct Bounds {
  std::array<double, 3> min{}, max{};
};

// A placement of a mesh with one material in the scene.
struct Instance {
  std::string node;  // path of its node, "/Root/Arm/Hand"
  Handle<Mesh> mesh;
  Handle<Material> material;
  Transform transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  // in the rest pose
  uint32_t id = 0, part = 0;                                            // values of the outputs of the same names
};

// A node that a program creates. Its transform is relative to the parent's.
struct NodePart {
  Handle<Mesh> mesh;
  Handle<Material> material;
};
struct NodeData {
  std::string name;    // without slashes; empty: "node"
  std::string parent;  // path of the parent; empty: the node is a root
  std::array<double, 3> translation{0, 0, 0};
  std::array<double, 4> rotation{0, 0, 0, 1};  // a quaternion x, y, z, w of any length above 0
  std::array<double, 3> scale{1, 1, 1};
  std::optional<Transform> matrix{};  // in place of the three above, which animations then cannot change
  std::vector<NodePart> parts;        // what the node shows: an instance for each, which follows the node
  std::vector<float> weights;         // of the morph targets of its meshes, at rest; empty: zeros
};

enum class Interpolation { Step, Linear, CubicSpline };
enum class AnimatedProperty { Translation, Rotation, Scale, Weights, Visible };

// Keyframes of one property of a node, as glTF defines them (3.11). A key has 3 values, 4 for a rotation (x, y, z, w),
// one per morph target for weights, and one that is not 0 for visible. A key of CubicSpline has three times as many:
// the in-tangent, the value and the out-tangent.
struct AnimationChannel {
  std::string node;  // its path
  AnimatedProperty property = AnimatedProperty::Translation;
  Interpolation interpolation = Interpolation::Linear;
  std::vector<float> times;  // seconds, at least 0, ascending
  std::vector<float> values;
};

// Triangulates a polygon that need not be convex, and returns the corners of its triangles: N corners become N - 2
// triangles, fewer than three none. A convex polygon becomes a fan. The triangles of a polygon that intersects or
// touches itself may overlap.
LATELIGHT_API std::vector<std::array<uint32_t, 3>> triangulate(std::span<const std::array<float, 3>> polygon);

// An environment that a program creates: an equirectangular image of linear radiance, twice as wide as it is high. The
// center column is at +X of the glTF frame, and the top row is the zenith.
struct EnvironmentData {
  uint32_t width = 0, height = 0;
  std::vector<std::array<float, 3>> radiance;  // rows from the top
};
// Reads a .hdr or .exr file with its values unchanged. Throws Error(BadInput).
LATELIGHT_API EnvironmentData readEnvironment(const std::string& file);

// A scene from a .gltf, .glb, .obj, .ply or .stl file, or "builtin:hall", "builtin:spheres" or "builtin:boxes". It is
// loaded once, rendered any number of times, and edited between frames. Renderers upload the changes before their next
// frame. Their pictures equal those of a new renderer, except for the environment, which is chosen when a renderer is
// created.
//
// An invalid edit throws Error(Usage) with a sentence that names the reason, and changes nothing. During an edit, no
// other thread may use a renderer of the scene. Every function of a scene that was moved from throws Error(Usage).
class LATELIGHT_API Scene {
 public:
  Scene();  // an empty scene, in glTF's frame
  explicit Scene(const std::string& source, const std::string& materialVariant = "");
  Scene(const std::string& source, const SceneOptions& options);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  uint64_t triangleCount() const;
  // Writes the scene as it is, with its edits, to a .glb file, or its geometry at rest to an .obj or .ply file. Throws
  // Error(Usage) for other names, for .obj and .ply files without visible triangles, and for files that cannot be
  // written.
  void exportTo(const std::string& file) const;
  // The environment of renderers that are created afterward without one of their own. It is not exported. Throws
  // Error(Usage) unless it is twice as wide as it is high.
  void setEnvironment(const EnvironmentData& environment);
  // The meaning of the ids in the outputs "id", "part" and "material", as JSON: the "ids" and "materials" of the side
  // file that docs/conventions.md describes.
  std::string idManifest() const;
  std::vector<Node> nodes() const;
  // Paths of the nodes that are the joints of an instance's skin, in the skin's order; none if it has no skin. A joint
  // that the file's scene does not contain has an empty path.
  std::vector<std::string> joints(Handle<Instance> instance) const;
  // The smallest box around the vertices of all visible instances in the rest pose, in the scene file's frame; empty if
  // there are none.
  std::optional<Bounds> bounds() const;
  const std::vector<Camera>& cameras() const;  // the scene's own, in the rest pose
  void addCamera(const Camera& camera);        // appended to cameras(), with its own exposure, shutter and readout
  const std::vector<Animation>& animations() const;
  // The scene's own cameras at a time; see Options::time, animation and loop.
  std::vector<Camera> camerasAt(double time, const std::string& animation = "", bool loop = false) const;
  // The first of the scene's own cameras, or a view that shows the whole scene in an image of this aspect (width /
  // height, finite and above 0). The camera is posed at `time`, see Options::time, animation and loop; without a time,
  // it is in its rest pose.
  Camera defaultCamera(float aspect, std::optional<double> time = {}, const std::string& animation = "",
                       bool loop = false) const;
  Camera lookAt(std::array<double, 3> eye, std::array<double, 3> target, float verticalFov = 40) const;

  // Instances, the visible objects. Lists are in the scene's order.
  std::vector<Handle<Instance>> instances() const;
  // The instances of a node by its path, one per primitive of its mesh. Throws Error(Usage) if no node has this path.
  std::vector<Handle<Instance>> instancesOf(const std::string& node) const;
  Instance instance(Handle<Instance> instance) const;
  // Afterward, animations no longer move the instance (skins and morph targets still deform it). The node of
  // addInstance() moves with it, unless nodes, skins, lights or cameras have been added that follow the node.
  void setTransform(Handle<Instance> instance, const Transform& transform);
  void assignMaterial(Handle<Instance> instance, Handle<Material> material);
  // The instance has its own root node, "/name", or "/name#2" and so on if that path exists, and the ids of that path.
  // An empty name is replaced by the mesh's name. The name must not contain a slash.
  Handle<Instance> addInstance(Handle<Mesh> mesh, Handle<Material> material, const Transform& transform,
                               const std::string& name = "");
  void removeInstance(Handle<Instance> instance);

  std::vector<Handle<Material>> materials() const;
  Material material(Handle<Material> material) const;
  void setMaterial(Handle<Material> material, const Material& values);  // the material keeps its textures
  // Adds a material without textures, or with those of another material.
  Handle<Material> addMaterial(const Material& values, std::optional<Handle<Material>> texturesOf = {});
  // Throws Error(Usage) with the name of an instance if one uses the material.
  void removeMaterial(Handle<Material> material);

  std::vector<Handle<Texture>> textures() const;
  Texture texture(Handle<Texture> texture) const;
  TextureData textureData(Handle<Texture> texture) const;
  Handle<Texture> addTexture(const TextureData& data);
  // Replaces the pixels; the size may change. All materials that sample the texture are affected. If `data` has no
  // name, the texture keeps its own.
  void setTextureData(Handle<Texture> texture, const TextureData& data);
  // Throws Error(Usage) with the name of a material if one samples the texture.
  void removeTexture(Handle<Texture> texture);
  std::optional<TextureUse> textureOf(Handle<Material> material, TextureSlot slot) const;
  // Texture coordinates are untransformed, or keep the transform of the texture that the material had in this slot. An
  // empty `use` removes the texture.
  void setTexture(Handle<Material> material, TextureSlot slot, const std::optional<TextureUse>& use);

  std::vector<Handle<Light>> lights() const;
  Light light(Handle<Light> light) const;
  // A light that is moved or rotated no longer follows its node.
  void setLight(Handle<Light> light, const Light& values);
  Handle<Light> addLight(const Light& values);
  void removeLight(Handle<Light> light);

  // Several instances may use one mesh; changes affect all of them.
  std::vector<Handle<Mesh>> meshes() const;
  Mesh mesh(Handle<Mesh> mesh) const;
  MeshData meshData(Handle<Mesh> mesh) const;  // in the rest pose, without its skin and morph targets
  // Only the skin and the morph targets of `data` deform it afterward. An empty name keeps its own. Throws Error(Usage)
  // if a node's weights require another number of morph targets.
  void setMesh(Handle<Mesh> mesh, const MeshData& data);
  Handle<Mesh> addMesh(const MeshData& data);
  // Throws Error(Usage) with the name of an instance if one uses the mesh.
  void removeMesh(Handle<Mesh> mesh);

  // Nodes, skins and animations that a program adds, as in a glTF file (docs/scene-files.md). They cannot be removed;
  // instances of nodes can. Throws Error(Usage) for scenes with Z up, such as STL files.
  //
  // Returns the node's path: "/Parent/name", or "/Parent/name#2" and so on if that path exists. instancesOf() returns
  // the instances of its parts. A mesh with morph targets can be part of one node only.
  std::string addNode(const NodeData& node);
  // Moves a node, also one of the file, to a place relative to its parent in the rest pose. All that is below it
  // follows: nodes, instances, lights, cameras and skins. Instances that setTransform() has placed, and lights that
  // setLight() has moved, stay. Animations of the node override it. Throws Error(Usage) for nodes of addInstance(),
  // which setTransform() moves, and for a matrix that shears if animations move the node.
  void setNodeTransform(const std::string& node, const Transform& parentFromNode);
  Handle<Skin> addSkin(const Skin& skin);
  // Appends to animations(). Options::time, animation and loop play it.
  void addAnimation(const std::string& name, const std::vector<AnimationChannel>& channels);
  // A camera and a light that follow a node, by its path: at its origin, along its -Z axis. The camera's pose, and the
  // light's position and direction, are not used.
  void addCamera(const Camera& camera, const std::string& node);
  Handle<Light> addLight(const Light& values, const std::string& node);

 private:
  friend class Renderer;
  struct Impl;
  Impl& filled() const;  // throws Error(Usage) after the scene was moved
  std::unique_ptr<Impl> impl_;
};

// A directional light, defined by the direction that its light comes from: azimuth 0 is the scene's front (+Z), 90 its
// right (+X).
struct Sun {
  float azimuth = 0, elevation = 45;  // degrees
  float illuminance = 3.14159265f;    // lux
};

// The exposure of a picture: a number of EV, as in `options.exposure = 1.5f`, or metered.
struct LATELIGHT_API Exposure {
  float ev = 0;            // radiance is multiplied by 2^ev
  bool automatic = false;  // in addition, each view is metered (docs/post.md)
  Exposure() = default;
  Exposure(float stops) : ev(stops) {}  // NOLINT(google-explicit-constructor): a number is an exposure
  static Exposure metered(float compensation = 0) {
    Exposure exposure(compensation);
    exposure.automatic = true;
    return exposure;
  }
  // Reads the command line's form: "1.5", "auto", "auto+1". Throws Error(Usage).
  static Exposure fromText(const std::string& text);
};

// The options of `latelight render`. options.def, in the same folder, lists them: every entry is a member here, and
// states its default, accepted values and effect. Values are checked when a picture is rendered.
struct Options {
// The including program's own macros with these names are restored below.
#pragma push_macro("OPTION_GROUP")
#pragma push_macro("OPTION_FLAG")
#pragma push_macro("OPTION_NUMBER")
#pragma push_macro("OPTION_ANGLE")
#pragma push_macro("OPTION_OPTIONAL")
#pragma push_macro("OPTION_CHOICE")
#pragma push_macro("OPTION_NAME")
#pragma push_macro("OPTION_ENTRY")
#pragma push_macro("OPTION_TEXT")
#pragma push_macro("OPTION_SIZE")
#pragma push_macro("OPTION_SUN")
#pragma push_macro("OPTION_EXPOSURE")
#undef OPTION_GROUP
#undef OPTION_FLAG
#undef OPTION_NUMBER
#undef OPTION_ANGLE
#undef OPTION_OPTIONAL
#undef OPTION_CHOICE
#undef OPTION_NAME
#undef OPTION_ENTRY
#undef OPTION_TEXT
#undef OPTION_SIZE
#undef OPTION_SUN
#undef OPTION_EXPOSURE
#define OPTION_FLAG(member, ...) bool member = false;
#define OPTION_NUMBER(type, member, name, defaultValue, ...) type member = defaultValue;
#define OPTION_ANGLE(member, name, defaultValue, ...) double member = defaultValue;
#define OPTION_OPTIONAL(type, member, ...) std::optional<type> member;
#define OPTION_CHOICE(Enum, member, name, defaultValue, ...) std::string member = defaultValue;
#define OPTION_ENTRY(Type, member, name, defaultValue, ...) std::string member = defaultValue;
#define OPTION_TEXT(Type, member, name, defaultValue, ...) std::string member = defaultValue;
#define OPTION_SIZE(width, height, name, defaultWidth, defaultHeight, ...) \
  uint32_t width = defaultWidth, height = defaultHeight;
#define OPTION_SUN(member, ...) std::optional<Sun> member;
#define OPTION_EXPOSURE(member, ...) Exposure member;
#include <latelight/options.def>
#pragma pop_macro("OPTION_GROUP")
#pragma pop_macro("OPTION_FLAG")
#pragma pop_macro("OPTION_NUMBER")
#pragma pop_macro("OPTION_ANGLE")
#pragma pop_macro("OPTION_OPTIONAL")
#pragma pop_macro("OPTION_CHOICE")
#pragma pop_macro("OPTION_NAME")
#pragma pop_macro("OPTION_ENTRY")
#pragma pop_macro("OPTION_TEXT")
#pragma pop_macro("OPTION_SIZE")
#pragma pop_macro("OPTION_SUN")
#pragma pop_macro("OPTION_EXPOSURE")

  // Members whose command-line form differs.
  bool picture = true;            // render the picture, Frame::rgba; if false, data outputs need no lighting
  std::vector<std::string> aovs;  // data outputs in addition to the picture: "depth", "normal", ...; "color" is the
                                  // linear picture
  std::vector<Camera> previousCameras, nextCameras;  // the cameras in the previous and the next frame: as many as are
                                                     // rendered, or none if the cameras are static
  bool continues = false;                            // true in a sequence: this frame follows the last rendered one

  // The form of the arrays of Results::Arrays. `formats` maps outputs to their elements: "rgba" to "rgba8" (default) or
  // "rgb8", outputs of floats to "float32" (default) or "float16", and outputs of integers to "uint32" (default) or
  // "uint16", in which 65535 stands for itself and all larger values. Half floats are rounded to nearest even.
  std::map<std::string, std::string> formats;
  bool channelsFirst = false;  // arrays are views x channels x rows x columns
};

// Factors that multiply a material's textures, in place of those of Material.
struct MaterialFactors {
  std::array<float, 4> baseColor{1, 1, 1, 1};
  float metallic = 1, roughness = 1;
  std::array<float, 3> emissive{0, 0, 0};
};

class DeviceArray;

// Numbers of all worlds in one array without padding, world by world, in place of a list of Worlds. Shaders convert
// arrays, so that the host's work does not grow with the number of worlds.
struct WorldArray {
  enum class Element { Float32, Float64, Uint8, Int32, Int64 };
  Element element = Element::Float32;
  uint32_t rows = 4;                          // of each 4x4 or 3x4 matrix, row by row: 4 or 3
  const void* host = nullptr;                 // in the host's memory, which submit() copies before it returns; or
  std::shared_ptr<const DeviceArray> device;  // in memory of Renderer::inputArray(), at an offset
  uint64_t offset = 0;                        // in bytes, a multiple of 16
  explicit operator bool() const { return host || device; }
};

struct WorldArrays {
  WorldArray transforms, previousTransforms, nextTransforms;           // count x instances matrices
  WorldArray exists;                                                   // count x instances bytes (Uint8)
  WorldArray cameraToWorld, previousCameraToWorld, nextCameraToWorld;  // count x cameras matrices
  WorldArray intrinsics;                                               // count x cameras camera matrices K, 3x3
  // In place of Worlds::factors: count x instances rows of 4, 1, 1 and 3 numbers. Those that are not given are the
  // material's.
  WorldArray baseColor, metallic, roughness, emissive;
  WorldArray materialChoice;  // count x instances indices (Int32 or Int64) in Worlds::palette, in place of materials
  // In place of Worlds::lightValues: count x lights rows of 3, 3, 3 and 1 numbers. Those that are not given are the
  // light's.
  WorldArray lightPosition, lightDirection, lightColor, lightIntensity;
  WorldArray environmentRotation, environmentIntensity;  // count numbers
  WorldArray environmentIndex;                           // count indices (Int32 or Int64) in Worlds::environments
  // Worlds::joints: count x joints matrices; Worlds::meshes: count x the vertices of all these meshes, mesh by mesh,
  // rows of 3. Those of the previous and the next frame are for motion.
  WorldArray jointTransforms, previousJointTransforms, nextJointTransforms;
  WorldArray vertices, previousVertices, nextVertices;
  uint64_t ready = 0;  // value of Renderer::exportInputSemaphore() at which arrays of the device are complete
};

// The state of many worlds of one scene (docs/worlds.md), for Renderer::submit(). Lists hold the values world by world.
// A list that is empty leaves the scene's values, which all worlds share.
struct Worlds {
  uint32_t count = 0;  // number of worlds, at least 1

  std::vector<Handle<Instance>> instances;  // those that the lists below describe; empty: Scene::instances()
  std::vector<Transform> transforms;        // count x instances, as Scene::setTransform() sets them
  std::vector<Transform> previousTransforms, nextTransforms;  // in the previous and the next frame, for motion;
                                                              // require `transforms`
  std::vector<uint8_t> exists;  // count x instances; 0: the world does not have the instance

  std::vector<Handle<Material>> materials;  // count x instances: the material of each instance
  std::vector<Handle<Material>> palette;    // those that arrays.materialChoice refers to
  std::vector<MaterialFactors> factors;     // count x instances: in place of the factors of that material

  std::vector<Handle<Light>> lights;  // those that `lightValues`, or arrays of lights, describe
  std::vector<Light> lightValues;     // count x lights, as Scene::setLight() sets them

  std::vector<double> environmentRotation;  // count, in place of the options of the same names
  std::vector<float> environmentIntensity;  // count
  // In place of the renderer's environment: those that worlds choose from, .hdr or .exr files or "studio", and count
  // indices in them. The renderer filters each once and keeps it.
  std::vector<std::string> environments;
  std::vector<uint32_t> environmentIndex;

  // The nodes, by their paths, whose transforms arrays.jointTransforms gives: from the node's frame to the scene
  // file's, as Node::transform. The meshes of all skins with these joints are deformed in each world; see
  // Scene::joints(). Other joints, and the instances at and below these nodes, have the scene's transforms.
  std::vector<std::string> joints;
  // The meshes whose vertices arrays.vertices gives, in object space and in the order of Scene::meshData(). Normals and
  // tangents follow the triangles (docs/worlds.md).
  std::vector<Handle<Mesh>> meshes;

  std::vector<Camera> cameras;  // the cameras of each world, at least one
  // The instance that each camera rides on, if any: its cameraToWorld is then relative to the instance's frame, whose
  // axes have the length 1 and must be a rotation. Empty: no camera rides.
  std::vector<std::optional<Handle<Instance>>> cameraInstances;
  std::vector<Transform> cameraToWorld;  // count x cameras, in place of Camera::cameraToWorld
  std::vector<Transform> previousCameraToWorld, nextCameraToWorld;  // empty: as cameraToWorld
  // count x cameras: focal lengths and principal point (fx, fy, cx, cy) in pixels of the rendered images. They replace
  // the cameras' fields of view and principal points, and those of their lenses, which keep model and distortion.
  // Orthographic cameras and lenses without focal lengths are rejected.
  std::vector<std::array<double, 4>> intrinsics;

  WorldArrays arrays;  // those that are given replace the lists of the same names
};

struct Aov {
  uint32_t channels = 0;
  std::vector<float> values;  // channels interleaved, rows from the top
  std::vector<uint32_t> ids;  // instead of values for "id", "part", "material" and "triangle"
};

struct Frame {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba;  // 8 bits, sRGB, straight alpha, rows from the top
  std::map<std::string, Aov> aovs;
  float exposure = 1;  // the factor that the picture's radiance is multiplied by; metered with Exposure::automatic
};

// The visible surface at a pixel's center. Options::axes and normalFrame select the frames of positions and normals.
struct Pick {
  uint32_t id = 0;    // value of the output "id"; 0: background, and no other member is set
  uint32_t part = 0;  // value of the output "part"
  std::string node, mesh, material;
  uint32_t primitive = 0;  // index of the mesh's primitive
  std::array<float, 3> position{}, normal{}, geonormal{};
  float depth = 0, distance = 0;  // meters
  std::array<float, 2> uv{};
};

// The surfaces that rays hit first: one value per ray. A ray that hits nothing has an infinite distance, and all its
// other values are 0. Options::axes and positionOrigin select the frames of positions and normals.
struct CastHits {
  std::vector<float> distance;                                    // meters along the ray
  std::vector<std::array<float, 3>> position, normal, geonormal;  // as the outputs of these names; normals are on the
                                                                  // side that the ray comes from
  std::vector<std::array<float, 2>> uv;                           // first set of texture coordinates
  std::vector<uint32_t> id, part, material;                       // values of the outputs of these names
  std::vector<uint32_t> triangle;                                 // index in the mesh of the part
  std::vector<float> intensity;  // from 0 to 1: reflectance at normal incidence times the cosine of incidence
};

// Where Renderer::cast() stores hits, one value per ray, as in CastHits. Arrays that are null are not needed and cost
// no time. The others must not overlap.
struct CastTargets {
  float* distance = nullptr;
  std::array<float, 3>*position = nullptr, *normal = nullptr, *geonormal = nullptr;
  std::array<float, 2>* uv = nullptr;
  uint32_t *id = nullptr, *part = nullptr, *material = nullptr, *triangle = nullptr;
  float* intensity = nullptr;
};

// --- labels (docs/labels.md) -----------------------------------------------------------------------------------------

// A box in pixels, y down; `width` and `height` are 0 if it is empty.
struct PixelBox {
  int64_t x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PixelBox&) const = default;
};

// An object of a picture: everything with one value of the output "id".
struct ObjectLabel {
  uint32_t id = 0;
  std::string node;  // path of its node
  // Pixels that show it; that it would cover in the picture with nothing else in the scene (its amodal mask); and the
  // same including up to one picture width and height beyond each edge.
  uint64_t visiblePixels = 0, amodalPixels = 0, fullPixels = 0;
  double visibleShare = 0;  // visiblePixels / fullPixels
  PixelBox visibleBox, amodalBox, fullBox;
  // The oriented box: the object's own frame, which is rigid, and the box along its axes, in meters. `objectToCamera`
  // is to OpenCV's camera frame.
  Transform objectToWorld{}, objectToCamera{};
  std::array<double, 3> boxMin{}, boxMax{};
  // Its corners in the picture: pixel coordinates and depth; x changes fastest, z slowest. NaN if not projected.
  std::array<std::array<double, 3>, 8> corners{};
  std::vector<uint8_t> visibleMask, amodalMask;  // one byte per pixel, 0 or 1, rows from the top
};

struct Labels {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> ids;         // the output "id"
  std::vector<ObjectLabel> objects;  // those that would cover a pixel by themselves, sorted by id
  // objects x objects: the number of pixels at which the object of the row is in front of that of the column, whether
  // or not others are in front of both.
  std::vector<uint64_t> occlusions;
};

// A named point that follows a node, which may be a joint of a skin.
struct Keypoint {
  std::string name;
  std::string node;                  // the node's path
  std::array<double, 3> position{};  // in the node's frame, before the node's scale
  double thickness = 0;              // meters that its own object may be in front of it, as flesh is before a joint
};

struct KeypointLabel {
  std::array<double, 3> position{};  // in the frame of Options::axes, meters; NaN in a world with a value that is not
                                     // finite
  std::array<double, 2> pixel{};     // NaN if the camera does not project it; it may lie outside the picture
  double depth = 0;                  // as the output "depth"; NaN likewise
  uint32_t visibility = 0;           // COCO's: 0 outside the picture or the planes, 1 occluded, 2 visible
};

// Where the surfaces of one picture are in another: one value per pixel of the first, rows from the top.
struct Correspondence {
  uint32_t width = 0, height = 0;
  std::vector<std::array<float, 2>> pixels;  // in the second picture, possibly outside of it; NaN for the background
                                             // and for points that the second camera does not project
  std::vector<float> depth;                  // as the output "depth" of the second picture; NaN likewise
  std::vector<uint8_t> visible;              // 1 if the second picture shows the same point
  std::vector<std::array<float, 3>> flow;    // scene flow: the point's displacement, meters; 0 for the background
};

// An entry of options.def, for programs that list the options.
struct OptionInfo {
  std::string group, name, member;  // "Picture", "--exposure", "exposure"
  std::string help;                 // one sentence
  std::string unit, range;          // only for numbers: "EV", "-60 to 60 EV"
  std::string defaultValue;         // the default, as on the command line; empty: see `without`
  std::string without;
  struct Name {
    std::string name, help;
  };
  std::vector<Name> names;  // accepted names
  bool anyText = false;     // other values than these names are accepted, too
};
LATELIGHT_API std::vector<OptionInfo> optionInfos();

// An output that Options::aovs accepts.
struct OutputInfo {
  std::string name, description, unit;
  uint32_t channels = 0;
  bool ids = false;  // integers, in Aov::ids
};
LATELIGHT_API std::vector<OutputInfo> outputInfos();

// Encodes an image as a PNG file in memory. `rgba` must have 4 bytes per pixel.
LATELIGHT_API std::vector<std::byte> encodePng(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba);

// --- lidar (docs/lidar.md) -------------------------------------------------------------------------------------------

// The firings of one scan of a lidar sensor, and its properties. The sensor's frame has X forward, Y left and Z up.
struct LidarPattern {
  std::string name;
  std::vector<std::array<double, 3>> directions;  // unit vectors in the sensor's frame
  std::vector<double> times;                      // seconds since the scan began, one per direction
  std::vector<uint16_t> rings;                    // index of the laser, from the lowest elevation up
  double period = 0;                              // seconds from one scan to the next
  double minRange = 0;                            // meters; nearer surfaces return nothing, and still block the beam
  double maxRange = std::numeric_limits<double>::infinity();    // meters; farther returns are discarded
  double ratedRange = std::numeric_limits<double>::infinity();  // meters, at 80 % reflectance and 90 % probability;
                                                                // infinite: any signal is detected
  double rangeNoise = 0, rangeResolution = 0;  // meters: the standard deviation; ranges are multiples of the resolution
  std::array<double, 2> divergence{};          // horizontal, vertical: full angles in radians at 1/e^2 of the center
  double echoSeparation = 1;                   // meters; nearer surfaces along a beam are one echo
};

struct LidarInfo {
  std::string name, description;
};
LATELIGHT_API std::vector<LidarInfo> lidarInfos();  // the sensors that lidarPattern() knows

// Returns a scan of a sensor by its name. `rate`: scans per second; `columns`: firings of each laser per scan, for
// sensors with a fixed number; 0: the sensor's default. `start`: seconds since the sensor was switched on, for sensors
// whose scans do not repeat. Throws Error(Usage) if there is no such sensor.
LATELIGHT_API LidarPattern lidarPattern(const std::string& sensor, double rate = 0, uint32_t columns = 0,
                                        double start = 0);

// Lasers that turn clockwise, seen from above. A scan begins forward.
struct SpinningLidar {
  std::string name = "spinning";
  std::vector<double> elevations;  // degrees, by laser
  std::vector<double> azimuths;    // degrees that each laser points to the right of the rotor; empty: 0
  std::vector<double> firing;      // seconds from the beginning of a cycle to each laser's firing; empty: all at once
  double cycle = 0;                // seconds from one firing of a laser to its next; 0: the period divided by `columns`
  uint32_t columns = 0;            // cycles per scan; 0: as many as fit
  double rate = 10;                // scans per second
};
LATELIGHT_API LidarPattern lidarPattern(const SpinningLidar& sensor);

struct LidarOptions {
  uint32_t samples = 1;  // rays per beam, up to 1024; 1: beams have no width
  // strongest, first, last, all, or dual: the strongest and the last, or the two strongest if these are the same
  std::string returns = "strongest";
  std::optional<uint64_t> seed = 0;  // of the noise of ranges and signals; null: no noise
  // Number of equal parts of the period. Each shows an animated scene at the time of its middle, and so do parts of the
  // same length before and after it. 1: all firings show the scene at Options::time.
  uint32_t slices = 1;
};

// One value per point, in the order of the firings, and from the nearest within a firing.
struct LidarPoints {
  std::vector<std::array<float, 3>> position;  // meters, in the sensor's frame at the time of the firing
  // Meters, in the frame of Options::axes and relative to Options::positionOrigin.
  std::vector<std::array<double, 3>> worldPosition;
  std::vector<double> time;      // seconds since the scan began
  std::vector<float> range;      // meters
  std::vector<float> intensity;  // from 0 to 1: the share of the beam that a surface returns, corrected for the range
  std::vector<uint16_t> ring;    // index of the laser, from the lowest elevation up
  std::vector<uint8_t> echo;     // 0: the nearest echo of the firing that was detected
  std::vector<uint32_t> firing;  // index in the pattern
  std::vector<uint32_t> id, part, material;  // values of the outputs of these names
};

// Writes a .ply or .pcd file (binary), a .bin file (KITTI: x, y, z, intensity) or an .npz file. `world`: positions in
// the world and not in the sensor's frame.
LATELIGHT_API void writePoints(const std::filesystem::path& path, const LidarPoints& points, bool world = false);

// Where pictures are stored until their ticket is taken.
enum class Results {
  ToHost,    // copied to the host as soon as they are complete
  OnDevice,  // in device memory; a ticket that is dropped costs no copy
  Arrays,    // in device memory, to be used there: Ticket::takeArrays()
};

// One output of all pictures of a ticket in device memory: views x rows x columns x channels, or views x channels x
// rows x columns with Options::channelsFirst, without padding, rows from the top. It is complete when it is returned,
// and nothing writes to it while a copy of this object exists, unless it is a target of a later call. After that, the
// renderer may render to it again without waiting for reads by other libraries. The functions of an empty array, such
// as that of a missing key of a map, throw Error(Usage).
class LATELIGHT_API DeviceArray {
 public:
  enum class Element { Float32, Uint32, Uint8, Float16, Uint16 };
  Element element = Element::Float32;
  std::array<uint64_t, 4> shape{};
  bool channelsFirst = false;  // the order of `shape`

  // The array's address in host memory, for CPU devices; otherwise null.
  const void* host() const;
  // The memory of other devices as an opaque file descriptor, owned by the caller, for cuImportExternalMemory(),
  // Vulkan's vkAllocateMemory() and similar functions, which also require `memoryBytes()`. The array begins at offset
  // 0. Throws Error(Usage) if host() is not null.
  int exportMemory() const;
  uint64_t memoryBytes() const;
  std::string deviceUuid() const;  // 32 hex digits
  // The renderer reuses memory. An importer may attach an object, which is released together with the memory, and a
  // callback, which is called before the renderer renders to the memory again, for example to wait for readers.
  void attach(std::shared_ptr<void> object) const;
  std::shared_ptr<void> attached() const;          // null if nothing is
  void copyToHost(std::span<std::byte> to) const;  // the array's bytes, shape and element give their number
  void beforeReuse(std::function<void()> call) const;

 private:
  friend class Ticket;
  friend class CastTicket;
  friend class Renderer;
  friend struct DeviceArrayMemory;
  struct Impl;
  const Impl& filled() const;  // throws Error(Usage) if the array is empty
  std::shared_ptr<Impl> impl_;
};

// Rays through worlds, as many in each. Origins and directions are arrays of worlds x count x 3 numbers, both Float32
// or both Float64, in the frame of Options::axes.
struct WorldRays {
  WorldArray origins, directions;
  uint64_t count = 0;                                            // per world
  double maxDistance = std::numeric_limits<double>::infinity();  // meters
};

// Pictures in flight, as returned by Renderer::submit().
class LATELIGHT_API Ticket {
 public:
  ~Ticket();
  Ticket(Ticket&&) noexcept;
  Ticket& operator=(Ticket&&) noexcept;

  bool done() const;  // true if take() would not wait for the device
  // Waits for the pictures and returns them in the order of their cameras. Rendering errors are thrown here. A
  // second call throws Error(Usage), and so does a ticket of Results::Arrays. Only if an exception of the callback of
  // Renderer::whileWaiting() has ended a call, another one continues the wait.
  std::vector<Frame> take();
  // The worlds with values that are not finite. Their images show only the background; other worlds are unaffected. May
  // wait until the device has read the values. Like take(), it throws Error(Usage) if a matrix is no transform, pose or
  // camera matrix.
  const std::vector<uint32_t>& invalidWorlds() const;
  // The factors that the pictures' radiance is multiplied by, in their order.
  std::vector<float> exposures() const;
  // The counterpart of take() for Results::Arrays: waits and returns each output by its name; the picture is "rgba".
  std::map<std::string, DeviceArray> takeArrays();

 private:
  friend class Renderer;
  Ticket();
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

// Rays in flight, as returned by Renderer::submitCast().
class LATELIGHT_API CastTicket {
 public:
  ~CastTicket();
  CastTicket(CastTicket&&) noexcept;
  CastTicket& operator=(CastTicket&&) noexcept;

  bool done() const;  // true if take() would not wait for the device
  // Waits until the targets of the call hold all hits. A second call throws Error(Usage), and so does a ticket of hits
  // that stay on the device. Error(Usage) is also thrown if a matrix of worlds is no transform. Only if an exception of
  // the callback of Renderer::whileWaiting() has ended a call, another one continues the wait.
  void take();
  // The counterpart of take() for hits that stay on the device: waits and returns each array of hits by its name.
  std::map<std::string, DeviceArray> takeArrays();

 private:
  friend class Renderer;
  CastTicket();
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

// Renders one scene on one device. Not thread-safe: use one renderer per thread, and take its tickets on that thread.
//
// A renderer belongs to the process that created it. In a forked process, every function of the renderer and of its
// tickets throws Error(Usage), as does DeviceArray::exportMemory(), and destructors do not access the device. The scene
// can be used there, and so can a new renderer of it. Every function of a renderer that was moved from throws
// Error(Usage).
class LATELIGHT_API Renderer {
 public:
  // `device` is "auto", "cpu", "cuda:N" (CUDA's device N), an index, a part of a name, or a UUID. `environment` is a
  // .hdr or .exr file, "studio", "none", or empty: the studio if the scene has no light. The scene must outlive the
  // renderer.
  explicit Renderer(const Scene& scene, const std::string& device = "auto", const std::string& environment = "");
  Renderer(const Scene& scene, const std::string& device, const EnvironmentData& environment);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  const std::string& deviceName() const;
  const std::string& deviceUuid() const;  // 32 hex digits
  // Messages of Vulkan's validation layers since the last call. The environment variable LATELIGHT_VALIDATION=1 enables
  // the layers.
  std::vector<std::string> validationMessages();
  // Sets a callback that is called every 50 ms while functions wait for the device, also if each of their waits is
  // shorter. An exception from it ends that function; submitted work still finishes, and a ticket can be taken after
  // all. The callback may call whileWaiting(), to replace itself, and other renderers. It must not edit the scene, and
  // every other call of this renderer or its tickets throws Error(Usage) there.
  void whileWaiting(std::function<void()> check);
  // Waits until the device has finished all submitted work and no pipeline is being compiled. Tickets must still be
  // taken.
  void finish();

  Frame render(const Camera& camera, const Options& options = {});
  // Renders several cameras at once, which is faster than one by one.
  std::vector<Frame> render(const std::vector<Camera>& cameras, const Options& options = {});
  // Submits the cameras and returns while the device renders them. Meanwhile, the scene may be edited, taken pictures
  // written, and more pictures submitted. Up to three tickets keep a device busy; each holds its pictures' memory until
  // it is taken or dropped.
  // `targets`: arrays of earlier calls with the same outputs, sizes and formats, by name. Results::Arrays are rendered
  // into them again, and their earlier values are lost. Throws Error(Usage) for arrays of another renderer, smaller
  // arrays, outputs that are not requested, and one array with two names.
  Ticket submit(const std::vector<Camera>& cameras, const Options& options = {}, Results results = Results::ToHost,
                const std::map<std::string, DeviceArray>& targets = {});
  // Renders the cameras of all worlds. Frames are in the order of the worlds, and of the cameras within each world.
  // Each has the bytes that the scene, edited to that world's state, has in a render of its own, except the coordinates
  // and curvature of objects at rest ("object-position", "nocs", "curvature"), which worlds do not change.
  std::vector<Frame> render(const Worlds& worlds, const Options& options = {});
  Ticket submit(const Worlds& worlds, const Options& options = {}, Results results = Results::ToHost,
                const std::map<std::string, DeviceArray>& targets = {});
  // Memory of at least `bytes` for arrays of worlds that other APIs write on the device: WorldArray::device. Calls of
  // other renderers reject it with Error(Usage). A call holds the memory that it reads until it has finished; once
  // nothing holds it, a later inputArray() returns it again.
  std::shared_ptr<const DeviceArray> inputArray(uint64_t bytes);
  // A timeline semaphore as an opaque file descriptor, owned by the caller, for cuImportExternalSemaphore() and similar
  // functions. Whoever writes arrays on the device signals it with increasing values; a call waits for
  // WorldArrays::ready on the device. Throws Error(NoDevice) if the device cannot export semaphores.
  int exportInputSemaphore();
  // The visible surfaces at pixels (x, y from the upper left) of such a picture, in the order of `pixels`. No lighting
  // is computed.
  std::vector<Pick> pick(const Camera& camera, const std::vector<std::array<uint32_t, 2>>& pixels,
                         const Options& options = {});
  // Casts rays through the scene, any number at once, and returns what each hits within `maxDistance` meters.
  // Directions may have any length; a ray whose direction is zero or not finite hits nothing. Origins, directions and
  // results are in the frame of Options::axes. Options::time and animation select the pose, and dataSurfaces selects if
  // rays hit blended surfaces. The first call builds a bounding volume hierarchy of the scene, which later calls
  // update.
  CastHits cast(std::span<const std::array<double, 3>> origins, std::span<const std::array<double, 3>> directions,
                const Options& options = {}, double maxDistance = std::numeric_limits<double>::infinity());

  // The same with arrays of the caller, which may use them for several calls.
  void cast(std::span<const std::array<double, 3>> origins, std::span<const std::array<double, 3>> directions,
            const CastTargets& targets, const Options& options = {},
            double maxDistance = std::numeric_limits<double>::infinity());
  void cast(std::span<const std::array<float, 3>> origins, std::span<const std::array<float, 3>> directions,
            const CastTargets& targets, const Options& options = {},
            double maxDistance = std::numeric_limits<double>::infinity());

  // Copies the rays, submits them, and returns while the device casts them. Meanwhile, the scene may be edited, and
  // more rays and pictures submitted. The arrays of `targets` must exist until the ticket is taken or dropped, and hold
  // the hits once it is taken. A limited number of rays is in flight, so a call with millions of them returns when the
  // last ones are submitted.
  CastTicket submitCast(std::span<const std::array<double, 3>> origins,
                        std::span<const std::array<double, 3>> directions, const CastTargets& targets,
                        const Options& options = {}, double maxDistance = std::numeric_limits<double>::infinity());
  CastTicket submitCast(std::span<const std::array<float, 3>> origins, std::span<const std::array<float, 3>> directions,
                        const CastTargets& targets, const Options& options = {},
                        double maxDistance = std::numeric_limits<double>::infinity());

  // Casts rays through worlds, from arrays that may be in the device's memory, and leaves the hits there: the arrays
  // `outputs` of CastHits by their names, with the shape 1 x worlds x rays x channels. Cameras and environments of the
  // worlds are ignored. The call waits until the arrays are complete, and not for WorldArrays::ready before that.
  // `targets`: arrays of earlier calls of this renderer for as many rays, one per output, which receive the hits. A ray
  // of a world with values that are not finite hits nothing. Rays through the scene itself are those of one world
  // without instances.
  std::map<std::string, DeviceArray> cast(const Worlds& worlds, const WorldRays& rays,
                                          const std::vector<std::string>& outputs = {"distance"},
                                          const Options& options = {},
                                          const std::map<std::string, DeviceArray>& targets = {});
  // The same with arrays of the caller, one value per ray, world by world.
  void cast(const Worlds& worlds, const WorldRays& rays, const CastTargets& targets, const Options& options = {});
  // Submits the rays and returns while the device casts them: CastTicket::takeArrays() returns the arrays of cast().
  // Arrays in the host's memory are copied. The call holds the device's memory that it reads until it has finished.
  // Hits are those of the scene at submission. The arrays of `targets` may change until the ticket is taken. Up to
  // three calls are in flight; a further one waits for the first. Calls for rays also wait for pictures of the raster
  // compute in flight.
  CastTicket submitCast(const Worlds& worlds, const WorldRays& rays,
                        const std::vector<std::string>& outputs = {"distance"}, const Options& options = {},
                        const std::map<std::string, DeviceArray>& targets = {});
  // The same with arrays of the caller, which must exist until the ticket is taken or dropped, and hold the hits after
  // CastTicket::take().
  CastTicket submitCast(const Worlds& worlds, const WorldRays& rays, const CastTargets& targets,
                        const Options& options = {});

  // Scans the scene once. `poses` are worldFromSensor, rigid and in the frame of Options::axes: one, or one per firing.
  // Options::time and animation select the scene's pose when the scan begins; without a time, the scene is at rest.
  LidarPoints scan(const LidarPattern& pattern, std::span<const Transform> poses, const LidarOptions& lidar = {},
                   const Options& options = {});

  // The objects of such a picture with their masks, boxes and occlusions. Each object is rendered once by itself.
  Labels labels(const Camera& camera, const Options& options = {});
  // Projects keypoints to such a picture, in their order. A ray from the camera decides about their visibility. Throws
  // Error(Usage) if the scene has no such node.
  std::vector<KeypointLabel> keypoints(const Camera& camera, const std::vector<Keypoint>& keypoints,
                                       const Options& options = {});
  // The same for the cameras of all worlds, in the order of the worlds and of the cameras within each world. The labels
  // of a view are those of the scene edited to its world's state.
  std::vector<Labels> labels(const Worlds& worlds, const Options& options = {});
  std::vector<std::vector<KeypointLabel>> keypoints(const Worlds& worlds, const std::vector<Keypoint>& keypoints,
                                                    const Options& options = {});
  // Finds the surfaces of the first camera's picture in the second camera's, which has the same size and shows the
  // scene at `secondTime`, by default at Options::time as well. Both times have the same range.
  Correspondence correspond(const Camera& first, const Camera& second, const Options& options = {},
                            std::optional<double> secondTime = {});
  // The same for the cameras of all worlds, in their order: the second picture of a view is that of the same camera in
  // the next frame, which nextTransforms, nextCameraToWorld and the arrays of the next frame describe.
  std::vector<Correspondence> correspond(const Worlds& worlds, const Options& options = {});

 private:
  friend class CastTicket;
  friend class Ticket;
  struct Impl;
  Impl& filled() const;         // throws Error(Usage) after the renderer was moved, and in a forked process
  std::shared_ptr<Impl> impl_;  // shared with its tickets
};

}  // namespace latelight
