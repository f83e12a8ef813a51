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

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#define LATELIGHT_API __attribute__((visibility("default")))

namespace latelight {

// The library's version, as in "0.1.0".
LATELIGHT_API const char* version();

// The program ends with these.
enum class ExitCode {
  Done = 0,
  Internal = 1,
  Usage = 2,       // an argument that can't be
  BadInput = 3,    // a file that is missing, broken or needs what is not supported
  NoDevice = 4,    // no Vulkan 1.3 device
  DeviceLost = 5,  // or out of memory, its or the machine's
  SomeFramesFailed = 6,
};

// One sentence: what, where, what to do.
class LATELIGHT_API Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& sentence);
  ~Error() override;
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

// Bytes of the machine's memory that this process may take for scenes, pictures and devices that run on the CPU; what
// would take more throws Error(DeviceLost) before it does. 0, as at first: three quarters of what is free.
LATELIGHT_API void setMemoryLimit(uint64_t bytes);

struct Camera {
  std::string name;
  // Camera frame to the scene file's frame, row-major. OpenCV's camera frame: X right, Y down, Z forward.
  std::array<double, 16> cameraToWorld{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  bool orthographic = false;
  float verticalFov = 40;  // degrees, full angle
  float halfHeight = 1;    // metres, orthographic cameras
  // Metres. However near it is, depth keeps its precision: 2^-40, unless something is to be cut away.
  float nearClip = 9.09494702e-13f;
  float farClip = std::numeric_limits<float>::infinity();
  float principalX = 0, principalY = 0;  // offset of the principal point from the centre, in half widths and half
                                         // heights, y up
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

// A .gltf or .glb file, or "builtin:hall", "builtin:spheres", "builtin:boxes". Loaded once, rendered as often as
// wanted.
class LATELIGHT_API Scene {
 public:
  explicit Scene(const std::string& source, const std::string& materialVariant = "");
  Scene(const std::string& source, const SceneOptions& options);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  uint64_t triangleCount() const;
  // What the ids in the outputs "id", "part" and "material" stand for, as JSON: the "ids" and "materials" of the side
  // file that docs/conventions.md describes.
  std::string idManifest() const;
  const std::vector<Camera>& cameras() const;  // the scene's own, at rest
  const std::vector<Animation>& animations() const;
  // The scene's own cameras where they are at a time; as Options::time, animation and loop say.
  std::vector<Camera> camerasAt(double time, const std::string& animation = "", bool loop = false) const;
  // The first of cameras(), or a view that shows all of it in a picture of this aspect (width / height).
  Camera defaultCamera(float aspect) const;
  Camera lookAt(std::array<float, 3> eye, std::array<float, 3> target, float verticalFov = 40) const;

 private:
  friend class Renderer;
  struct Hidden;
  std::unique_ptr<Hidden> hidden_;
};

// A directional light by where it comes from: azimuth 0 is the scene's front (+Z), 90 its right (+X).
struct Sun {
  float azimuth = 0, elevation = 45;  // degrees
  float illuminance = 3.14159265f;    // lux
};

// The choices of `latelight render`; names are those of `latelight list`.
struct Options {
  uint32_t width = 1280, height = 720;
  std::string layout = "compact";
  std::string normals = "octahedral";
  std::string normalSpace = "layout";    // or "world", "view"
  std::string position = "ray";          // how a layout without positions rebuilds them: or "matrix", "reciprocal"
  std::string lighting = "fullscreen";   // `latelight list lighting`
  std::string volumesOrder = "classic";  // of the technique volumes: or "killzone"
  std::string shading = "ggx";           // or "ggx-compensated", "blinn-phong"
  std::string tonemap = "khronos";
  std::string transparency = "exact";   // `latelight list transparency`
  std::string dataSurfaces = "opaque";  // which surfaces the outputs in `aovs` and pick() show: or "any"
  std::string shadows = "d32";          // or "none", "d16", "rgba8", "rgba8-classic"
  std::string shadowFilter = "pcf";     // or "hard", "pcss"
  std::string shadowLights = "auto";    // or "all", "none", a number, names of lights by comma
  uint32_t shadowAtlas = 4096;          // side of the square that all shadow maps fit in, texels
  float lightSize = 0.05f;              // metres: radius of lights that have none of their own, for "pcss"
  float sunAngle = 0.53f;               // degrees across: the same of directional lights
  std::optional<Sun> sun;               // a directional light beside the scene's
  uint32_t superSampling = 1;           // N x N ordered samples a pixel
  uint32_t samples = 1;                 // a pixel, by the device's multisampling: 1 or 4, without superSampling
  uint32_t anisotropy = 0;  // samples of a texture along a pixel's footprint, 1 to 16; 0: the device's usual
  float exposure = 0;       // EV
  float environmentIntensity = 1;
  float environmentRotation = 0;  // degrees
  bool environmentBackground = false;
  // Composition and post-processing (docs/post.md); off by default.
  std::string ambientOcclusion = "none";  // or "gtao"
  float aoRadius = 0;                     // metres; 0: by the scene's size
  float aoStrength = 1;
  float bloom = 0;                                  // the share of light that glows, 0 to 1
  float bloomRadius = 0.7f;                         // 0 to 1
  float bloomThreshold = 0;                         // luminance that is left alone
  std::string bloomFireflies = "damp";              // or "keep"
  float fogDensity = 0;                             // 1/m
  std::array<float, 3> fogColor{0.5f, 0.5f, 0.5f};  // linear, after exposure
  float fogHeight = 0;                              // metres in which it thins out; 0: the same everywhere
  float fogBase = 0;                                // metres, up
  bool fxaa = false;

  std::optional<double> time;                        // seconds; none: the scene at rest
  std::string animation;                             // which plays: a name, a number, or "all"; empty: the first
  bool loop = false;                                 // times beyond its end begin again; else its ends hold
  double framesPerSecond = 24;                       // "motion" is to a frame before and a frame after
  std::vector<Camera> previousCameras, nextCameras;  // then, as many as are rendered; none: cameras stand
  bool temporalAntiAliasing = false;
  bool continues = false;  // a sequence: this frame follows the one rendered last

  std::vector<std::string> aovs;  // beside the picture: "depth", "normal", ...; "color" is the linear picture
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

// What a pixel shows, at its centre. Positions and normals are in the scene file's frame.
struct Pick {
  uint32_t id = 0;    // as in the output "id"; 0: background, and nothing below is set
  uint32_t part = 0;  // as in the output "part"
  std::string node, mesh, material;
  uint32_t primitive = 0;  // of the mesh
  std::array<float, 3> position{}, normal{}, geonormal{};
  float depth = 0, distance = 0;  // metres
  std::array<float, 2> uv{};
};

// One scene on one device. Not thread-safe; use one a thread.
class LATELIGHT_API Renderer {
 public:
  // `device`: "auto", "cpu", an index, a part of a name or a UUID. `environment`: a .hdr or .exr file, "studio",
  // "none", or empty: the studio where the scene has no light. The scene must outlive the renderer.
  explicit Renderer(const Scene& scene, const std::string& device = "auto", const std::string& environment = "");
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  Frame render(const Camera& camera, const Options& options = {});
  // Several cameras at once, faster than one by one.
  std::vector<Frame> render(const std::vector<Camera>& cameras, const Options& options = {});
  // What pixels (x, y from the upper left) of such a picture show, in their order. Lights nothing.
  std::vector<Pick> pick(const Camera& camera, const std::vector<std::array<uint32_t, 2>>& pixels,
                         const Options& options = {});

 private:
  struct Hidden;
  std::unique_ptr<Hidden> hidden_;
};

}  // namespace latelight
