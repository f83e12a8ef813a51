#include "app/render_options.h"

#include <cmath>

#include "app/parse.h"
#include "render/gbuffer/layout.h"

namespace latelight::app {

void parseSettings(RenderOptions& o) {
  render::Settings& s = o.settings;
  std::tie(s.width, s.height) = parseSize(o.size);
  s.temporal = o.aa == "taa";
  s.superSampling = s.temporal ? 1 : parseSuperSampling(o.aa);
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

std::optional<DebugRequest> parseDebug(const std::string& debug, bool moving) {
  if (debug.empty()) return std::nullopt;
  DebugRequest request;
  if (debug == "targets") {
    request.targets = true;
  } else if (debug == "sheet") {
    request.sheet = true;
    for (const output::AovInfo& aov : output::aovs())
      if (aov.aov != output::Aov::Motion || moving) request.aovs.push_back(aov.aov);
  } else {
    request.aovs = output::parseAovs(debug == "lights" ? "lights-tested,lights-used" : debug);
    request.sheet = request.aovs.size() > 1;
  }
  return request;
}

namespace {

void addSceneOptions(CLI::App& c, RenderOptions& o) {
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

void addTimeOptions(CLI::App& c, RenderOptions& o) {
  c.add_option("--time", o.time, "Seconds into the animation; without it, and without --frames, the scene is at rest");
  c.add_option("--frames", o.frames, "Frames A-B of a sequence; frame N shows the time N / fps. -o needs {frame}");
  c.add_option("--fps", o.fps, "Frames a second: of --frames, and of what --aov motion is a frame before and after")
      ->capture_default_str();
  c.add_option("--animation", o.animation, "Which one plays: a name, a number, or all; default: the first");
  c.add_flag("--loop", o.loop, "Times beyond the animation's end begin again; else its ends hold");
  c.add_option("--turn", o.turn, "Degrees a second that the camera turns about --target or the scene's middle")
      ->capture_default_str();
}

void addLookOptions(CLI::App& c, RenderOptions& o) {
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
  c.add_option("--aa", o.aa, "Anti-aliasing: none, taa (temporal), or ssN for N x N ordered samples a pixel (ss2, ss4)")
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

void addOutputOptions(CLI::App& c, RenderOptions& o) {
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

void addRenderOptions(CLI::App& command, RenderOptions& options) {
  addSceneOptions(command, options);
  addTimeOptions(command, options);
  addLookOptions(command, options);
  addOutputOptions(command, options);
}

}  // namespace latelight::app
