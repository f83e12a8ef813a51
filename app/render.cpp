// latelight render: a scene file in, pictures and per-pixel data out.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/commands.h"
#include "app/parse.h"
#include "base/files.h"
#include "base/log.h"
#include "base/parallel.h"
#include "output/debug.h"
#include "output/files.h"
#include "output/targets.h"
#include "render/gbuffer/layout.h"
#include "render/renderer.h"
#include "render/session.h"
#include "render/view.h"
#include "scene/framing.h"

namespace latelight::app {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string scene = "builtin:hall", out, size = "1280x720", variant;
  std::string camera, eye, target, up, orbit;
  std::optional<double> fov;
  std::string aovs, debug, hdri, background = "transparent", aa = "none", normalFrame = "world", axes = "file";
  std::string device = "auto", graph;
  double hdriRotate = 0;
  uint32_t frame = 0;
  bool json = false, noSideFile = false, validate = false, normalsChosen = false;
  render::Settings settings;
};

double seconds(Clock::time_point from) {
  return std::chrono::duration<double>(Clock::now() - from).count();
}

// --- options to settings --------------------------------------------------------------------------------------------

void parseSettings(Options& o) {
  render::Settings& s = o.settings;
  std::tie(s.width, s.height) = parseSize(o.size);
  s.superSampling = parseSuperSampling(o.aa);
  s.environmentRotation = static_cast<float>(o.hdriRotate * M_PI / 180.0);
  if (o.background == "hdri")
    s.background = render::Background::Environment;
  else if (o.background != "transparent") {
    s.background = render::Background::Color;
    s.backgroundColor = parseColor(o.background);
  }
  s.normalFrame = parseChoice<render::NormalFrame>("--normal-frame", o.normalFrame,
                                                   {{"world", render::NormalFrame::World},
                                                    {"opencv", render::NormalFrame::OpenCv},
                                                    {"opengl", render::NormalFrame::OpenGl}});
  s.zUp = parseChoice<bool>("--axes", o.axes, {{"file", false}, {"z-up", true}});
  render::checkSettings(s);
  const render::Layout& layout = render::findLayout(s.layout);
  if (o.normalsChosen && layout.fixedNormal)
    badUsage("--normals means nothing to the layout {}, which keeps normals as {}", layout.name, layout.fixedNormal);
}

bool contains(const std::vector<output::Aov>& aovs, output::Aov aov) {
  return std::find(aovs.begin(), aovs.end(), aov) != aovs.end();
}

// What --debug shows: "sheet", AOV names, or "targets". The picture then leaves as a PNG of those.
struct DebugRequest {
  std::vector<output::Aov> aovs;
  bool sheet = false;
  bool targets = false;  // the layout's own, instead of AOVs
};

std::optional<DebugRequest> parseDebug(const std::string& debug) {
  if (debug.empty()) return std::nullopt;
  DebugRequest request;
  if (debug == "targets") {
    request.targets = true;
  } else if (debug == "sheet") {
    request.sheet = true;
    for (const output::AovInfo& aov : output::aovs()) request.aovs.push_back(aov.aov);
  } else {
    request.aovs = output::parseAovs(debug == "lights" ? "lights-tested,lights-used" : debug);
    request.sheet = request.aovs.size() > 1;
  }
  return request;
}

// --- cameras --------------------------------------------------------------------------------------------------------

const scene::Camera& findCamera(const scene::Scene& scene, const std::string& wanted) {
  for (const scene::Camera& camera : scene.cameras)
    if (camera.name == wanted) return camera;
  if (auto index = parseIndex(wanted); index && *index < scene.cameras.size()) return scene.cameras[*index];
  std::string names;
  for (size_t i = 0; i < scene.cameras.size(); ++i)
    names += fmt::format("{}{} \"{}\"", i ? ", " : "", i, scene.cameras[i].name);
  badUsage("{} has no camera \"{}\"; {}", scene.source, wanted,
           names.empty() ? "it has none: use --eye and --target, or --orbit" : "it has: " + names);
}

scene::Camera chooseCamera(const scene::Scene& scene, const Options& o) {
  const float aspect = static_cast<float>(o.settings.width) / static_cast<float>(o.settings.height);
  if (o.fov && !(*o.fov > 0 && *o.fov < 180))
    badUsage("--fov must be an angle between 0 and 180 degrees, not {}", *o.fov);
  const float fov = o.fov ? static_cast<float>(*o.fov * M_PI / 180.0) : scene::kDefaultVerticalFov;
  if (!o.camera.empty() + !o.eye.empty() + !o.orbit.empty() > 1)
    badUsage("--camera, --eye and --orbit each place the camera; use one of them");
  if (o.eye.empty() != o.target.empty()) badUsage("--eye and --target need each other");
  if (!o.up.empty() && o.eye.empty()) badUsage("--up needs --eye and --target");

  if (!o.eye.empty()) {
    std::optional<glm::vec3> up;
    if (!o.up.empty()) up = parseVector("--up", o.up);
    return scene::lookAt(scene, parseVector("--eye", o.eye), parseVector("--target", o.target), up, fov);
  }
  if (!o.orbit.empty()) {
    Orbit orbit = parseOrbit(o.orbit);
    return scene::orbitCamera(scene, orbit.azimuth, orbit.elevation, orbit.distance, fov, aspect);
  }
  scene::Camera camera;
  if (!o.camera.empty())
    camera = findCamera(scene, o.camera);
  else
    camera = scene.cameras.empty() ? scene::frameScene(scene, aspect) : scene.cameras.front();
  if (o.fov && camera.orthographic)
    badUsage("--fov means nothing to the camera \"{}\": it is orthographic", camera.name);
  if (o.fov) camera.verticalFov = fov;
  return camera;
}

// --- metadata -------------------------------------------------------------------------------------------------------

output::CameraMetadata describeCamera(const scene::Camera& camera, const scene::Scene& scene, const Options& o) {
  const render::Settings& s = o.settings;
  const shared::View view = render::makeView(camera, s.width, s.height);
  output::CameraMetadata m;
  m.name = camera.name;
  const double halfWidth = s.width * 0.5, halfHeight = s.height * 0.5;
  const shared::Projection& p = view.projection;
  m.intrinsics = {p.H * halfWidth, 0, halfWidth * (1 + p.X), 0, p.V * halfHeight, halfHeight * (1 - p.Z), 0, 0, 1};
  m.cameraToWorld = render::openCvPose(camera, scene, s.zUp);
  m.orthographic = camera.orthographic;
  m.nearClip = camera.nearClip;
  m.farClip = camera.farClip;
  return m;
}

std::map<std::string, std::string> describeSettings(const Options& o, const std::string& environment) {
  const render::Settings& s = o.settings;
  return {{"size", fmt::format("{}x{}", s.width, s.height)},
          {"layout", s.layout},
          {"normals", s.normals},
          {"normal-space", s.normalSpace},
          {"position", s.position},
          {"lighting", s.lighting},
          {"shading", s.shading},
          {"tonemap", s.tonemap},
          {"volumes-order", s.volumesOrder},
          {"aa", o.aa},
          {"exposure", fmt::format("{}", s.exposure)},
          {"hdri", environment.empty() ? "none" : environment},
          {"hdri-rotate", fmt::format("{}", o.hdriRotate)},
          {"hdri-intensity", fmt::format("{}", s.environmentIntensity)},
          {"background", o.background}};
}

output::Metadata describe(const scene::Scene& scene, const scene::Camera& camera, const vk::Device& device,
                          const std::string& environment, const Options& o) {
  output::Metadata m;
  m.scene = scene.name;
  m.source = scene.source;
  m.frame = o.frame;
  m.camera = describeCamera(camera, scene, o);
  m.axes = scene.yUp && !o.settings.zUp ? "gltf" : "z-up";
  m.normalFrame = o.normalFrame;
  m.exposure = std::exp2(o.settings.exposure);
  m.device = {device.info().name, device.info().driver, device.info().uuid};
  m.versions = {{"latelight", LATELIGHT_VERSION}, {"vulkan", device.info().apiVersion}};
  m.settings = describeSettings(o, environment);
  for (const scene::Instance& instance : scene.instances)
    m.ids.push_back({instance.id, scene.nodes[instance.node].path, scene.meshes[instance.mesh].name,
                     scene.materials[instance.material].name});
  return m;
}

// --- the run --------------------------------------------------------------------------------------------------------

struct Times {  // seconds
  double load = 0, upload = 0, render = 0, write = 0, total = 0;
};

void printReport(const scene::Scene& scene, const vk::Device& device, const render::Renderer& renderer,
                 const std::vector<std::filesystem::path>& files, const Times& times) {
  Json passes = Json::array();
  for (const graph::PassTime& pass : renderer.times())
    passes.push_back({{"pass", pass.name}, {"milliseconds", pass.milliseconds}});
  Json names = Json::array();
  for (const auto& file : files) names.push_back(file.string());
  Json report{{"files", names},
              {"scene", scene.source},
              {"triangles", scene.triangleCount()},
              {"lights", scene.lights.size()},
              {"device", device.info().name},
              {"seconds",
               {{"load", times.load},
                {"upload", times.upload},
                {"render", times.render},
                {"write", times.write},
                {"total", times.total}}},
              {"gpu", passes}};
  fmt::print("{}\n", report.dump(2));
}

// Writes the pictures of --debug: one, or a labelled sheet of several.
std::vector<std::filesystem::path> writeDebug(const DebugRequest& debug, const output::FrameOutput& frame,
                                              const output::Metadata& metadata, const std::string& out) {
  const auto ids = std::find_if(frame.aovs.begin(), frame.aovs.end(),
                                [](const output::AovImage& aov) { return aov.aov == output::Aov::Id; });
  std::vector<output::Labelled> pictures;
  for (const output::AovImage& aov : frame.aovs) {
    if (!contains(debug.aovs, aov.aov)) continue;
    output::Picture picture = aov.aov == output::Aov::Color && !frame.display.empty()
                                  ? output::Picture{frame.width, frame.height, frame.display}
                                  : output::debugPicture(aov, ids == frame.aovs.end() ? nullptr : &*ids);
    pictures.push_back({std::string(output::info(aov.aov).name), std::move(picture)});
  }
  const std::filesystem::path path =
      output::fillPattern(out, debug.sheet ? "sheet" : output::info(debug.aovs.front()).name, metadata);
  output::writePicture(path, debug.sheet ? output::contactSheet(pictures) : pictures.front().picture);
  if (out == "-") return {};
  return {path};
}

// Writes the picture of --debug targets.
std::vector<std::filesystem::path> writeTargets(const output::RawGbuffer& gbuffer, const output::Metadata& metadata,
                                                const std::string& out) {
  const std::filesystem::path path = output::fillPattern(out, "targets", metadata);
  output::writePicture(path, output::contactSheet(output::targetPictures(gbuffer)));
  if (out == "-") return {};
  return {path};
}

// What leaves, checked before anything costs time; and what has to be rendered for it.
output::OutputRequest planOutput(Options& o, const std::optional<DebugRequest>& debug) {
  output::OutputRequest request{.pattern = o.out};
  if (!o.aovs.empty()) request.aovs = output::parseAovs(o.aovs);
  if (o.noSideFile) request.sideFile = false;
  if (debug && !o.aovs.empty()) badUsage("--debug and --aov each say what leaves; use one of them");
  if (debug && o.out != "-" && output::formatOf(o.out) != output::Format::Png)
    badUsage("--debug writes PNG; give -o a name that ends in .png");
  if ((o.out == "-") + (o.graph == "-") + o.json > 1)
    badUsage("-o -, --dump-graph - and --json each fill standard output; use one of them");
  output::checkOutput(request);
  if (!o.graph.empty()) output::checkWritable(o.graph);

  render::Settings& s = o.settings;
  s.aovs = debug ? debug->aovs : request.aovs;
  s.display = debug ? contains(debug->aovs, output::Aov::Color) : output::usesDisplay(request);
  if (s.display && !debug) std::erase(s.aovs, output::Aov::Color);
  if (debug && !debug->targets && !contains(s.aovs, output::Aov::Id))
    s.aovs.push_back(output::Aov::Id);  // what is background
  return request;
}

void render(Options& o) {
  const auto start = Clock::now();
  parseSettings(o);
  const std::optional<DebugRequest> debug = parseDebug(o.debug);
  const output::OutputRequest request = planOutput(o, debug);

  // The device starts while the scene loads: they share nothing.
  auto deviceStart = inBackground(
      [&] { return std::make_unique<vk::Device>(vk::DeviceOptions{.selector = o.device, .validation = o.validate}); });
  Times times;
  const scene::Scene scene = scene::load(o.scene, {.variant = o.variant});
  const scene::Camera camera = chooseCamera(scene, o);
  // A background to show is a reason for an environment, lights or not.
  const std::string asked = o.hdri.empty() && o.background == "hdri" ? "studio" : o.hdri;
  const std::string environmentName = render::environmentName(scene, asked);
  const std::optional<scene::Environment> environment = render::loadEnvironment(environmentName);
  times.load = seconds(start);

  const std::unique_ptr<vk::Device> device = deviceStart.get();
  auto mark = Clock::now();
  render::Renderer renderer(*device, scene, environment ? &*environment : nullptr);
  times.upload = seconds(mark);

  mark = Clock::now();
  output::FrameOutput frame;
  output::RawGbuffer gbuffer;
  if (debug && debug->targets)
    gbuffer = renderer.readTargets(camera, o.settings);
  else
    frame = std::move(renderer.render(std::span(&camera, 1), o.settings).front());
  times.render = seconds(mark);

  mark = Clock::now();
  const output::Metadata metadata = describe(scene, camera, *device, environmentName, o);
  std::vector<std::filesystem::path> files;
  if (debug && debug->targets)
    files = writeTargets(gbuffer, metadata, o.out);
  else
    files = debug ? writeDebug(*debug, frame, metadata, o.out) : output::writeOutput(request, frame, metadata);
  if (!o.graph.empty()) writeFile(o.graph, std::as_bytes(std::span(renderer.graphviz())));
  times.write = seconds(mark);
  times.total = seconds(start);

  if (o.json) printReport(scene, *device, renderer, files, times);
  for (const std::string& message : device->validationMessages())
    fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
}

void addSceneOptions(CLI::App& c, Options& o) {
  c.add_option("SCENE", o.scene, "A .gltf or .glb file, or builtin:hall, builtin:spheres, builtin:boxes")
      ->capture_default_str();
  c.add_option("-o,--out", o.out,
               "Output: .png, .exr or .npy; {aov} {frame} {camera} {scene} are filled in; - is standard output")
      ->required();
  c.add_option("--size", o.size, "Width x height in pixels")->capture_default_str();
  c.add_option("--variant", o.variant, "Material variant by name (KHR_materials_variants)");
  c.add_option("--camera", o.camera, "The scene's camera by name or number");
  c.add_option("--eye", o.eye, "Camera position x,y,z in the scene file's frame, metres");
  c.add_option("--target", o.target, "What --eye looks at, x,y,z");
  c.add_option("--up", o.up, "The camera's up x,y,z; default: the file's up");
  c.add_option("--orbit", o.orbit, "Camera around the scene: azimuth,elevation[,distance] in degrees and metres");
  c.add_option("--fov", o.fov, "Full vertical field of view, degrees");
  c.add_option("--frame", o.frame, "Number that fills in {frame}");
}

void addLookOptions(CLI::App& c, Options& o) {
  render::Settings& s = o.settings;
  c.add_option("--layout", s.layout, "G-buffer layout (latelight list layouts)")->capture_default_str();
  c.add_option("--normals", s.normals, "Normal encoding (latelight list normals)")->capture_default_str();
  c.add_option("--normal-space", s.normalSpace, "Where normals are encoded: layout (its own), world or view")
      ->capture_default_str();
  c.add_option("--position", s.position, "Position from depth: ray, matrix or reciprocal (latelight list positions)")
      ->capture_default_str();
  c.add_option("--lighting", s.lighting, "Lighting technique (latelight list lighting)")->capture_default_str();
  c.add_option("--shading", s.shading, "ggx or blinn-phong")->capture_default_str();
  c.add_option("--volumes-order", s.volumesOrder, "How --lighting volumes culls by stencil: classic or killzone")
      ->capture_default_str();
  c.add_option("--aa", o.aa, "Anti-aliasing: none, or ssN for N x N ordered samples a pixel (ss2, ss4)")
      ->capture_default_str();
  c.add_option("--hdri", o.hdri,
               "Environment light: a .hdr or .exr file, studio, or none; default: studio where the scene has no light");
  c.add_option("--hdri-rotate", o.hdriRotate, "Degrees about up; 0 puts the picture's centre at +X, 90 at +Z")
      ->capture_default_str();
  c.add_option("--hdri-intensity", s.environmentIntensity, "Factor on the environment")->capture_default_str();
  c.add_option("--exposure", s.exposure, "EV: radiance times 2^EV")->capture_default_str();
  c.add_option("--tonemap", s.tonemap, "khronos, aces, agx, reinhard or none")->capture_default_str();
  c.add_option("--background", o.background, "transparent, hdri, or a colour: #rrggbb or r,g,b in 0..1 (sRGB)")
      ->capture_default_str();
}

void addOutputOptions(CLI::App& c, Options& o) {
  c.add_option("--aov", o.aovs, "What leaves, by comma: color,depth,... (latelight list aovs)");
  c.add_option(
      "--debug", o.debug,
      "Pictures of data for the eye: sheet (all), lights, AOV names by comma, or targets: those of the layout");
  c.add_option("--normal-frame", o.normalFrame, "Frame of normal outputs: world, opencv or opengl")
      ->capture_default_str();
  c.add_option("--axes", o.axes, "Frame of positions and poses: file (the scene file's own) or z-up")
      ->capture_default_str();
  c.add_flag("--no-side-file", o.noSideFile, "No JSON file beside data outputs");
  c.add_option("--device", o.device, "auto, cpu, a number, a name or a UUID (latelight devices)")
      ->capture_default_str();
  c.add_flag("--json", o.json, "A report on standard output: files, times, passes");
  c.add_option("--dump-graph", o.graph, "Write the frame graph as Graphviz to this file");
  c.add_flag("--validate", o.validate, "Run under the Vulkan validation layers; any message is an error");
}

}  // namespace

void addRenderCommand(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("render", "Render a scene to pictures and per-pixel data");
  addSceneOptions(*command, *options);
  addLookOptions(*command, *options);
  addOutputOptions(*command, *options);
  command->callback([options, command] {
    options->normalsChosen = command->count("--normals") > 0;
    render(*options);
  });
}

}  // namespace latelight::app
