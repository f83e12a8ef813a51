// Latelight's public C++ API. No Vulkan type is in it, and nothing else is exported by the library.
//
//   latelight::Scene scene("helmet.glb");
//   latelight::Renderer renderer(scene);
//   latelight::Options options;
//   options.aovs = {"depth", "normal", "id"};
//   latelight::Frame frame = renderer.render(scene.defaultCamera(16.0f / 9), options);
//   // frame.rgba, frame.aovs.at("depth").values, ...
//
// Units are metres and degrees, colours linear Rec.709 but for Frame::rgba. Poses and positions are in the scene file's
// own frame (glTF: right-handed, Y up). Every function may throw latelight::Error.
#pragma once

#include <latelight/error.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace latelight {

// The library's version, as in "0.1.0".
LATELIGHT_API const char* version();

// Bytes of the machine's memory that this process may take for scenes, pictures and devices that run on the CPU; what
// would take more throws Error(DeviceLost) before it does. 0, as at first: three quarters of what is free.
LATELIGHT_API void setMemoryLimit(uint64_t bytes);

enum class LensModel {
  Pinhole,          // any focal lengths and principal point, without distortion
  OpenCv,           // with OpenCV's radial and tangential distortion: k1 k2 p1 p2 k3 k4 k5 k6
  Fisheye,          // Kannala and Brandt's, as OpenCV's: k1 k2 k3 k4, of the angle to the axis
  Equirectangular,  // all around: the axis in the middle, longitude to the right, latitude up
  CubeMap,          // six faces side by side: +X -X +Y -Y +Z -Z, of the camera's frame
};

// How a camera's rays go (docs/lenses.md), calibrated for pictures of width x height pixels; one of another size is the
// same picture, scaled. Pixel centres are at half-integers: to OpenCV's cx and cy, which count from the first pixel's
// centre, add 0.5.
struct Lens {
  LensModel model = LensModel::Pinhole;
  double width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels; equirectangular pictures and cube maps have none
  std::array<double, 8> distortion{};     // the first of them, as the model says
};

struct Camera {
  std::string name;
  // Camera frame to the scene file's frame, row-major. OpenCV's camera frame: X right, Y down, Z forward.
  std::array<double, 16> cameraToWorld{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  bool orthographic = false;
  float verticalFov = 40;  // degrees, full angle
  float halfHeight = 1;    // metres, orthographic cameras
  // Width / height of the camera's own frame. Pictures show all of it, unless Options::cameraFit is "vertical"; without
  // one, or with a lens, every picture has the vertical extent above.
  std::optional<float> aspect{};
  // Metres. However near it is, depth keeps its precision: 2^-40, unless something is to be cut away.
  float nearClip = 9.09494702e-13f;
  float farClip = std::numeric_limits<float>::infinity();
  float principalX = 0, principalY = 0;  // offset of the principal point from the centre, in half widths and half
                                         // heights, y up
  std::optional<Lens> lens{};            // instead of the field of view, the principal point and, where it bends rays,
                                         // the near and the far plane
};

struct Animation {
  std::string name;
  float duration = 0;  // seconds
};

struct SceneOptions {
  std::string materialVariant{};            // KHR_materials_variants by name; empty: the file's default
  std::vector<std::string> allowOutside{};  // folders it may read files from, beside its own and what lies below that
  // Whole subtrees of nodes under one "id"; at most one of the two. Nodes deeper than idDepth have the id of their
  // ancestor at that depth (roots are at 0); of idNodes, names or paths, each one's subtree has its id, but for what
  // lies below another of them. A name that no node has throws Error(Usage).
  std::optional<uint32_t> idDepth{};
  std::vector<std::string> idNodes{};
};

// --- what a scene consists of, to be read and edited ----------------------------------------------------------------

// Identifies an element of a scene; small, and copied freely. A handle to a removed element is rejected with
// Error(Usage), even if another element has taken its place; so is a handle of another scene.
template <typename Element>
struct Handle {
  uint32_t scene = 0;  // 0: of none
  uint32_t index = 0, generation = 0;
  bool operator==(const Handle&) const = default;
};

// Row-major: object space to the scene file's frame; the last row is 0 0 0 1.
using Transform = std::array<double, 16>;

enum class AlphaMode { Opaque, Mask, Blend };

// glTF's metallic-roughness material. Factors multiply the textures that the material has.
struct Material {
  std::string name;  // given when it is added; setMaterial() leaves it as it is
  uint32_t id = 0;   // as in the output "material"; the scene gives it
  std::array<float, 4> baseColor{1, 1, 1, 1};
  float metallic = 1, roughness = 1;       // 0 to 1
  std::array<float, 3> emissive{0, 0, 0};  // radiance; may be above 1
  AlphaMode alphaMode = AlphaMode::Opaque;
  float alphaCutoff = 0.5f;  // with AlphaMode::Mask: what has less alpha is not there
  bool doubleSided = false, unlit = false;
  float normalScale = 1;        // of the normal map's slopes
  float occlusionStrength = 1;  // 0 to 1
  float specular = 1;           // KHR_materials_specular
  std::array<float, 3> specularColor{1, 1, 1};
  float f0 = 0.04f;  // what a dielectric reflects at normal incidence: ((ior - 1) / (ior + 1))^2
  // The extensions KHR_materials_* lay these over the surface, or let light through it. Strengths, roughness and
  // colours are from 0 to 1, and a strength of 0 leaves the layer out.
  float clearcoat = 0, clearcoatRoughness = 0;
  float clearcoatNormalScale = 1;            // of its own normal map's slopes
  std::array<float, 3> sheenColor{0, 0, 0};  // black: no sheen
  float sheenRoughness = 0;
  float anisotropy = 0, anisotropyRotation = 0;  // rotation in degrees, counter-clockwise from the tangent
  float iridescence = 0, iridescenceIor = 1.3f;  // index of refraction of the film, at least 1
  float iridescenceThinnest = 100, iridescenceThickest = 400;  // nanometres, where the texture is 0 and 1
  float transmission = 0;
  float thickness = 0;                                                 // metres in object space; 0: thin-walled
  std::array<float, 3> attenuationColor{1, 1, 1};                      // what is left of white light after the distance
  float attenuationDistance = std::numeric_limits<float>::infinity();  // metres
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
  bool srgb = true;  // its colours are sRGB-encoded; alpha never is
};

// Pixels of a texture that a program makes: RGBA, 8 bits a channel, straight alpha, rows from the top.
struct TextureData {
  std::string name;
  uint32_t width = 0, height = 0;
  bool srgb = true;  // as base colours and emitted light are stored; not for normals, roughness and other data
  std::vector<uint8_t> rgba;
};

// How a material samples a texture. Channels are those of glTF: roughness is green and metalness blue.
struct TextureUse {
  Handle<Texture> texture;
  Wrap wrapU = Wrap::Repeat, wrapV = Wrap::Repeat;
  bool smooth = true;  // linear filters and mip levels; else the nearest texel
  uint32_t uvSet = 0;  // or 1
};

// As in KHR_lights_punctual.
struct Light {
  std::string name;
  std::string type = "point";                // or another of `latelight list lights`
  std::array<double, 3> position{0, 0, 0};   // not of directional lights
  std::array<float, 3> direction{0, 0, -1};  // from the light, of any length; not of point lights
  std::array<float, 3> color{1, 1, 1};
  float intensity = 1;                   // candela; of directional lights lux
  std::optional<float> range;            // metres; without one it reaches everything
  double innerCone = 0, outerCone = 45;  // half angles of spot lights, degrees
  double size = 0;                       // radius, metres; of directional lights what they fill across, degrees
  std::optional<bool> castShadow;        // true: before all lights that don't say; false: never
};

// Triangles, as they are at rest.
struct Mesh {
  std::string name;
  uint64_t vertices = 0, triangles = 0;
  std::array<float, 3> boundsMin{}, boundsMax{};  // object space
  bool deforms = false;                           // a skin or morph targets move its vertices
};

// A mesh that a program makes, in object space. Positions are required; each of the others is empty, or has one value a
// position.
struct MeshData {
  std::string name;
  std::vector<std::array<float, 3>> positions;
  std::vector<uint32_t> indices;              // three a triangle, fronts counter-clockwise; empty: each three positions
  std::vector<std::array<float, 3>> normals;  // empty: flat, those of the triangles, which then share no vertex
  std::vector<std::array<float, 4>> tangents;  // and the bitangent's sign; empty: made from uv, where there is some
  std::vector<std::array<float, 2>> uv, uv1;   // the first and the second set, v down
  std::vector<std::array<float, 4>> colors;    // linear, 0 to 1; multiply the base color
};

// A node of the file, or of an instance that was added.
struct Node {
  std::string path;                                                     // "/Root/Arm/Hand"
  std::string parent;                                                   // its path; empty: a root
  std::string mesh;                                                     // its name; empty: it has none
  Transform transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  // to the scene file's frame, at rest
  uint32_t id = 0;                                                      // as in the output "id"
};

struct Bounds {
  std::array<double, 3> min{}, max{};
};

// A mesh placed in the scene.
struct Instance {
  std::string node;  // path of the node that shows it, "/Root/Arm/Hand"
  Handle<Mesh> mesh;
  Handle<Material> material;
  Transform transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};  // at rest
  uint32_t id = 0, part = 0;                                            // as in the outputs of that name
};

// A .gltf or .glb file, or "builtin:hall", "builtin:spheres", "builtin:boxes". Loaded once, rendered as often as
// wanted, and edited between frames: renderers upload what changed before their next frame, and give the very picture
// that one made afresh would give, but for the environment, which is chosen when a renderer is made.
//
// An edit throws Error(Usage) for what can't be, in a sentence that names it, and changes nothing then. No renderer of
// the scene may be at work in another thread meanwhile.
class LATELIGHT_API Scene {
 public:
  Scene();  // an empty one, in glTF's frame
  explicit Scene(const std::string& source, const std::string& materialVariant = "");
  Scene(const std::string& source, const SceneOptions& options);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  uint64_t triangleCount() const;
  // What the ids in the outputs "id", "part" and "material" stand for, as JSON: the "ids" and "materials" of the side
  // file that docs/conventions.md describes.
  std::string idManifest() const;
  std::vector<Node> nodes() const;
  std::optional<Bounds> bounds() const;        // of all instances at rest, in the scene file's frame; none: it is empty
  const std::vector<Camera>& cameras() const;  // the scene's own, at rest
  void addCamera(const Camera& camera);        // behind them
  const std::vector<Animation>& animations() const;
  // The scene's own cameras where they are at a time; as Options::time, animation and loop say.
  std::vector<Camera> camerasAt(double time, const std::string& animation = "", bool loop = false) const;
  // The first of the scene's own cameras, or a view that shows the whole scene in a picture of this aspect (width /
  // height). The camera is where it is at `time`, as Options::time, animation and loop say; without a time, at rest.
  Camera defaultCamera(float aspect, std::optional<double> time = {}, const std::string& animation = "",
                       bool loop = false) const;
  Camera lookAt(std::array<double, 3> eye, std::array<double, 3> target, float verticalFov = 40) const;

  // Instances: what is seen. Lists are in the scene's order.
  std::vector<Handle<Instance>> instances() const;
  // Those of a node by its path: one a primitive of its mesh. Throws Error(Usage) where no node is called so.
  std::vector<Handle<Instance>> instancesOf(const std::string& node) const;
  Instance instance(Handle<Instance> instance) const;
  // From then on no animation moves it (skins and morph targets still do).
  void setTransform(Handle<Instance> instance, const Transform& transform);
  void assignMaterial(Handle<Instance> instance, Handle<Material> material);
  // With a root node of its own, "/name", or "/name#2" and so on where that is taken, and ids of that path. Without a
  // name it has the mesh's.
  Handle<Instance> addInstance(Handle<Mesh> mesh, Handle<Material> material, const Transform& transform,
                               const std::string& name = "");
  void removeInstance(Handle<Instance> instance);

  std::vector<Handle<Material>> materials() const;
  Material material(Handle<Material> material) const;
  void setMaterial(Handle<Material> material, const Material& values);  // its textures stay
  // Without textures, or with those of another material.
  Handle<Material> addMaterial(const Material& values, std::optional<Handle<Material>> texturesOf = {});
  // Throws Error(Usage) that names an instance which shows the material, if there is one.
  void removeMaterial(Handle<Material> material);

  std::vector<Handle<Texture>> textures() const;
  Texture texture(Handle<Texture> texture) const;
  TextureData textureData(Handle<Texture> texture) const;
  Handle<Texture> addTexture(const TextureData& data);
  // Replaces the pixels; the size may change. All materials that sample the texture change with it. Without a name it
  // keeps its own.
  void setTextureData(Handle<Texture> texture, const TextureData& data);
  // Throws Error(Usage) that names a material which samples the texture, if there is one.
  void removeTexture(Handle<Texture> texture);
  std::optional<TextureUse> textureOf(Handle<Material> material, TextureSlot slot) const;
  // With uv as they are, or, where the material had a texture there, transformed as that one's. Nothing: takes it away.
  void setTexture(Handle<Material> material, TextureSlot slot, const std::optional<TextureUse>& use);

  std::vector<Handle<Light>> lights() const;
  Light light(Handle<Light> light) const;
  // A light that is moved or turned follows its node no longer.
  void setLight(Handle<Light> light, const Light& values);
  Handle<Light> addLight(const Light& values);
  void removeLight(Handle<Light> light);

  // Several instances may show one mesh: all of them change with it.
  std::vector<Handle<Mesh>> meshes() const;
  Mesh mesh(Handle<Mesh> mesh) const;
  MeshData meshData(Handle<Mesh> mesh) const;             // at rest
  void setMesh(Handle<Mesh> mesh, const MeshData& data);  // no skin deforms it from then on; no name: it keeps its own
  Handle<Mesh> addMesh(const MeshData& data);
  // Throws Error(Usage) that names an instance which shows the mesh, if there is one.
  void removeMesh(Handle<Mesh> mesh);

 private:
  friend class Renderer;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A directional light by where it comes from: azimuth 0 is the scene's front (+Z), 90 its right (+X).
struct Sun {
  float azimuth = 0, elevation = 45;  // degrees
  float illuminance = 3.14159265f;    // lux
};

// The choices of `latelight render`. options.def, beside this file, is the list of them: every entry there is a member
// here, with its default, what it takes and what it does. Values are checked when a picture is rendered.
struct Options {
// The including program's own macros of these names are restored below.
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
#define OPTION_FLAG(member, ...) bool member = false;
#define OPTION_NUMBER(type, member, name, normal, ...) type member = normal;
#define OPTION_ANGLE(member, name, normal, ...) double member = normal;
#define OPTION_OPTIONAL(type, member, ...) std::optional<type> member;
#define OPTION_CHOICE(Enum, member, name, normal, ...) std::string member = normal;
#define OPTION_ENTRY(Type, member, name, normal, ...) std::string member = normal;
#define OPTION_TEXT(Type, member, name, normal, ...) std::string member = normal;
#define OPTION_SIZE(width, height, name, normalWidth, normalHeight, ...) \
  uint32_t width = normalWidth, height = normalHeight;
#define OPTION_SUN(member, ...) std::optional<Sun> member;
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

  // What the command line has in another form.
  bool picture = true;            // the picture to look at, Frame::rgba; without it data alone need no light
  std::vector<std::string> aovs;  // beside the picture: "depth", "normal", ...; "color" is the linear picture
  std::vector<Camera> previousCameras, nextCameras;  // where they were and will be, a frame before and after the time:
                                                     // as many as are rendered; none: cameras stand
  bool continues = false;                            // a sequence: this frame follows the one rendered last
};

struct Aov {
  uint32_t channels = 0;
  std::vector<float> values;  // channels interleaved, rows from the top
  std::vector<uint32_t> ids;  // instead of values for "id", "part" and "material"
};

struct Frame {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgba;  // 8 bits, sRGB, straight alpha, rows from the top
  std::map<std::string, Aov> aovs;
};

// What a pixel shows, at its centre. Positions and normals are in the frames that Options::axes and normalFrame say.
struct Pick {
  uint32_t id = 0;    // as in the output "id"; 0: background, and nothing below is set
  uint32_t part = 0;  // as in the output "part"
  std::string node, mesh, material;
  uint32_t primitive = 0;  // of the mesh
  std::array<float, 3> position{}, normal{}, geonormal{};
  float depth = 0, distance = 0;  // metres
  std::array<float, 2> uv{};
};

// An entry of options.def, for programs that list the options.
struct OptionInfo {
  std::string group, name, member;  // "Picture", "--exposure", "exposure"
  std::string help;                 // one sentence
  std::string unit, range;          // of numbers: "EV", "-60 to 60 EV"
  std::string normal;               // the default, as on the command line; empty: `without` says what applies
  std::string without;
  struct Name {
    std::string name, help;
  };
  std::vector<Name> names;  // that it takes
  bool anyText = false;     // it takes more than those names, or has none
};
LATELIGHT_API std::vector<OptionInfo> optionInfos();

// What Options::aovs takes.
struct OutputInfo {
  std::string name, description, unit;
  uint32_t channels = 0;
  bool ids = false;  // whole numbers, in Aov::ids
};
LATELIGHT_API std::vector<OutputInfo> outputInfos();

// An environment that a program makes: an equirectangular picture, its centre column at +X of the glTF frame and its
// top row at the zenith. Linear radiance; as wide as twice its height.
struct EnvironmentData {
  uint32_t width = 0, height = 0;
  std::vector<std::array<float, 3>> radiance;  // rows from the top
};

// The picture as a PNG file in memory.
LATELIGHT_API std::vector<std::byte> encodePng(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba);

// Where pictures are until they are taken.
enum class Results {
  ToHost,    // on their way to the host from the moment they are done
  OnDevice,  // in the device's memory; a ticket that is dropped costs no copy
  Arrays,    // the same, to be used there: Ticket::takeArrays()
};

// An output of all pictures of a ticket in the device's memory: views x rows x columns x channels, without gaps, rows
// from the top. It is finished when it is handed out, and nothing writes to it as long as one copy of this lives; then
// the renderer may render to it again, without waiting for what other libraries still read.
class LATELIGHT_API DeviceArray {
 public:
  enum class Element { Float32, Uint32, Uint8 };
  Element element = Element::Float32;
  std::array<uint64_t, 4> shape{};

  // Where the host has it: of CPU devices. Else null.
  const void* host() const;
  // Other devices' memory as an opaque file descriptor, the caller's from then on, for cuImportExternalMemory(),
  // Vulkan's vkAllocateMemory() and the like; the array begins at 0. `memoryBytes`: as they must be told.
  int exportMemory() const;
  uint64_t memoryBytes() const;
  std::string deviceUuid() const;  // 32 hex digits
  // The renderer uses memory again. An importer may keep something of its own with it, which then is dropped with the
  // memory, and be called before it is rendered to again, as to wait for its readers.
  std::shared_ptr<void>& import() const;
  void beforeReuse(std::function<void()> call) const;

 private:
  friend class Ticket;
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

// Pictures on their way: what Renderer::submit() returns.
class LATELIGHT_API Ticket {
 public:
  ~Ticket();
  Ticket(Ticket&&) noexcept;
  Ticket& operator=(Ticket&&) noexcept;

  bool done() const;  // take() would not wait for the device
  // The pictures, in the order of their cameras; waits for them. Once: Error(Usage) after that. What went wrong on the
  // way is thrown here.
  std::vector<Frame> take();
  // Instead, of Results::Arrays: each output by its name, the picture as "rgba"; waits for them.
  std::map<std::string, DeviceArray> takeArrays();

 private:
  friend class Renderer;
  Ticket();
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

// One scene on one device. Not thread-safe; use one per thread, and take its tickets there.
//
// A renderer belongs to the process that created it. In a process forked from that one, every function of the renderer
// and of its tickets throws Error(Usage), as does DeviceArray::exportMemory(), and destructors leave the device alone.
// The scene can be used there, and so can a new renderer of it.
class LATELIGHT_API Renderer {
 public:
  // `device`: "auto", "cpu", an index, a part of a name or a UUID. `environment`: a .hdr or .exr file, "studio",
  // "none", or empty: the studio where the scene has no light. The scene must outlive the renderer.
  explicit Renderer(const Scene& scene, const std::string& device = "auto", const std::string& environment = "");
  Renderer(const Scene& scene, const std::string& device, const EnvironmentData& environment);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  const std::string& deviceName() const;
  // Of Vulkan's validation layers since the last call, which LATELIGHT_VALIDATION=1 in the environment turns on.
  std::vector<std::string> validationMessages();
  // Called every 50 ms while a function waits for the device. What it throws ends that function, and what was submitted
  // is done without it.
  void whileWaiting(std::function<void()> check);
  // Returns when the device has finished everything that was submitted and no pipeline is being compiled. The tickets
  // are still to be taken.
  void finish();

  Frame render(const Camera& camera, const Options& options = {});
  // Several cameras at once, faster than one by one.
  std::vector<Frame> render(const std::vector<Camera>& cameras, const Options& options = {});
  // The same, and returns while the device works on them: meanwhile the scene may be edited, pictures that were taken
  // be written, and more be submitted. Up to three tickets keep a device busy; each holds its pictures' memory until
  // it is taken or dropped.
  Ticket submit(const std::vector<Camera>& cameras, const Options& options = {}, Results results = Results::ToHost);
  // What pixels (x, y from the upper left) of such a picture show, in their order. Lights nothing.
  std::vector<Pick> pick(const Camera& camera, const std::vector<std::array<uint32_t, 2>>& pixels,
                         const Options& options = {});

 private:
  friend class Ticket;
  struct Impl;
  std::shared_ptr<Impl> impl_;  // its tickets keep it too
};

}  // namespace latelight
