#include "app/render_options.h"

#include <cmath>

#include "app/parse.h"
#include "app/render_pick.h"
#include "base/memory.h"
#include "base/text.h"
#include "render/gbuffer/layout.h"
#include "scene/ids.h"

namespace latelight::app {

void parseSettings(RenderOptions& o) {
  render::Settings& s = o.settings;
  if (!o.memory.empty()) {
    const uint64_t limit = parseMemory(o.memory);
    if (limit == 0) badUsage("--memory takes a size, as in 512M or 4G, not \"{}\"", o.memory);
    setMemoryLimit(limit);
  }
  std::tie(s.width, s.height) = parseSize(o.size);
  if (!o.idNodes.empty()) {
    const std::vector<std::string_view> names = splitAtCommas(o.idNodes);
    o.idGrouping.nodes.assign(names.begin(), names.end());
  }
  scene::checkGrouping(o.idGrouping);
  render::setAntiAliasing(s, o.aa);
  s.environmentRotation = static_cast<float>(o.hdriRotate * M_PI / 180.0);
  s.sunAngle = static_cast<float>(o.sunAngle * M_PI / 180.0);
  if (!o.sun.empty()) s.sun = parseSun(o.sun);
  if (o.background == "hdri")
    s.background = render::Background::Environment;
  else if (o.background != "transparent") {
    s.background = render::Background::Color;
    s.backgroundColor = parseColor("--background takes transparent, hdri,", o.background);
  }
  s.fog.color = parseColor("--fog-color takes", o.fogColor);
  s.normalFrame = parseChoice<render::NormalFrame>("--normal-frame", o.normalFrame,
                                                   {{"world", render::NormalFrame::World},
                                                    {"opencv", render::NormalFrame::OpenCv},
                                                    {"opengl", render::NormalFrame::OpenGl}});
  s.zUp = parseChoice<bool>("--axes", o.axes, {{"file", false}, {"z-up", true}});
  render::checkSettings(s);
  o.pixels = parsePixels(o.picks);
  render::checkPixels(s, o.pixels);
  const render::Layout& layout = render::findLayout(s.layout);
  if (o.normalsChosen && layout.fixedNormal)
    badUsage("--normals means nothing to the layout {}, which keeps normals as {}", layout.name, layout.fixedNormal);
  if (o.positionChosen && layout.fixedPosition)
    badUsage("--position means nothing to the layout {}, which keeps positions as {}", layout.name,
             layout.fixedPosition);
}

std::optional<DebugRequest> parseDebug(const std::string& debug, bool moving) {
  if (debug.empty()) return std::nullopt;
  DebugRequest request;
  if (debug == "targets") {
    request.targets = true;
  } else if (debug == "sheet") {
    request.sheet = true;
    for (const output::AovInfo& aov : output::aovs()) {
      if (aov.aov == output::Aov::Samples) continue;  // the same everywhere but with --aa msaa4
      if (aov.aov != output::Aov::Motion || moving) request.aovs.push_back(aov.aov);
    }
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
               "Output: .png, .exr or .npy; {aov} {frame} {camera} {scene} are filled in; - is standard output");
  c.add_option("--size", o.size, "Width x height in pixels")->capture_default_str();
  c.add_option("--variant", o.variant, "Material variant by name (KHR_materials_variants)");
  c.add_option("--allow-outside", o.allowOutside,
               "Folder that the scene may read files from, beside its own; may be repeated")
      ->type_name("FOLDER")
      ->expected(1)
      ->take_all();
  c.add_option("--memory", o.memory,
               "Memory of the machine that may be taken, as in 4G or 512M; default: three quarters of what is free");
  c.add_option("--id-depth", o.idGrouping.depth,
               "Nodes deeper than N have the id of their ancestor at depth N; the scene's roots are at depth 0");
  c.add_option("--id-nodes", o.idNodes,
               "Nodes, by comma, as names or paths: all below each has its id; the deepest that is named counts");
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
  c.add_option("--shading", s.shading, "ggx, ggx-compensated (no energy is lost between facets) or blinn-phong")
      ->capture_default_str();
  c.add_option("--volumes-order", s.volumesOrder, "How --lighting volumes culls by stencil: classic or killzone")
      ->capture_default_str();
  c.add_option("--transparency", s.transparency, "Alpha-blended surfaces: exact, sorted, weighted or none")
      ->capture_default_str();
  c.add_option("--shadows", s.shadows, "none, or how shadow maps store depth (latelight list shadows)")
      ->capture_default_str();
  c.add_option("--shadow-filter", s.shadowFilter, "hard, pcf or pcss (latelight list shadow-filters)")
      ->capture_default_str();
  c.add_option("--shadow-lights", s.shadowLights,
               "Which lights cast shadows: auto (the 8 most important), all, none, a number, or names by comma")
      ->capture_default_str();
  c.add_option("--shadow-atlas", s.shadowAtlas, "Side of the square that all shadow maps fit in, texels")
      ->capture_default_str();
  c.add_option("--light-size", s.lightSize, "Radius of point and spot lights without one, metres (pcss)")
      ->capture_default_str();
  c.add_option("--sun-angle", o.sunAngle, "What directional lights without an angle fill, degrees across (pcss)")
      ->capture_default_str();
  c.add_option("--sun", o.sun, "A directional light from azimuth,elevation[,lux], beside the scene's; as in 30,40,3");
  c.add_option("--aa", o.aa,
               "Anti-aliasing: none, fxaa, msaa4, taa, or ssN for N x N ordered samples a pixel (latelight list aa)")
      ->capture_default_str();
  c.add_option("--anisotropy", s.anisotropy,
               "Samples of a texture along a pixel's footprint, 1 to 16; default: 8, on CPU devices 1");
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

void addPostOptions(CLI::App& c, RenderOptions& o) {
  render::Settings& s = o.settings;
  c.add_option("--ao", s.ao.method, "Ambient occlusion of the environment's light: none or gtao")
      ->capture_default_str();
  c.add_option("--ao-radius", s.ao.radius,
               "How far occluders count, metres; default: a twentieth of the scene's radius");
  c.add_option("--ao-strength", s.ao.strength, "Exponent on the visible share of the sky")->capture_default_str();
  c.add_option("--bloom", s.bloom.strength, "Share of light that glows, 0 to 1; 0.05 is much")->capture_default_str();
  c.add_option("--bloom-radius", s.bloom.radius, "How far it glows, 0 to 1")->capture_default_str();
  c.add_option("--bloom-threshold", s.bloom.threshold, "Luminance that does not glow, after exposure")
      ->capture_default_str();
  c.add_option("--bloom-fireflies", s.bloom.fireflies, "Lone bright pixels: damp or keep")->capture_default_str();
  c.add_option("--fog", s.fog.density, "Fog's extinction, 1/m: 0.05 hides 63 % of what is 20 m away")
      ->capture_default_str();
  c.add_option("--fog-color", o.fogColor, "#rrggbb or r,g,b in 0..1 (sRGB), before the tonemap")->capture_default_str();
  c.add_option("--fog-height", s.fog.height, "Metres upwards in which fog thins to 1/e; 0: the same everywhere")
      ->capture_default_str();
  c.add_option("--fog-base", s.fog.base, "Height at which it has its density, metres")->capture_default_str();
}

void addOutputOptions(CLI::App& c, RenderOptions& o) {
  c.add_option("--aov", o.aovs, "What leaves, by comma: color,depth,... (latelight list aovs)");
  c.add_option("--data-surfaces", o.settings.dataSurfaces,
               "Whose data leave: opaque (the nearest surface that is not blended) or any")
      ->capture_default_str();
  c.add_option("--pick", o.picks, "Say what the pixel x,y shows, on standard output; may be repeated")
      ->expected(1)
      ->take_all();
  c.add_option("--debug", o.debug,
               "Pictures of data for the eye: sheet (all), lights, samples, AOV names by comma, or targets: those of "
               "the layout");
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
  addPostOptions(command, options);
  addOutputOptions(command, options);
}

void noteChoices(const CLI::App& command, RenderOptions& options) {
  options.normalsChosen = command.count("--normals") > 0;
  options.positionChosen = command.count("--position") > 0;
  options.frameChosen = command.count("--frame") > 0;
}

}  // namespace latelight::app
