// What a picture is rendered with: the choices of `latelight render`, as data.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "output/aov.h"

namespace latelight::render {

enum class NormalFrame { World, OpenCv, OpenGl };  // of the normal and geonormal outputs
enum class Background { Transparent, Color, Environment };

// Composition and post-processing (docs/post.md); all off by default.
struct AmbientOcclusionSettings {
  std::string method = "none";
  std::optional<float> radius;  // metres; without, a share of the scene's size (kAoRadiusShare)
  float strength = 1;           // the visible share of the sky is raised to it
};
struct BloomSettings {
  float strength = 0;   // the share of light that is spread, 0 to 1
  float radius = 0.7f;  // 0 to 1: the share of it that goes on from each size of glow to the next, twice as wide
  float threshold = 0;  // luminance that is left alone
  std::string fireflies = "damp";
};
struct FogSettings {
  float density = 0;      // extinction, 1/m
  glm::vec3 color{0.5f};  // linear; as the picture has it after exposure
  float height = 0;       // metres upwards in which density falls to 1/e; 0: the same everywhere
  float base = 0;         // metres, where density is `density`: up in the scene file's frame
};

// A directional light. Azimuth and elevation say where it comes from, as an orbiting camera's do.
struct SunLight {
  float azimuth = 0, elevation = 0;  // radians
  float illuminance = 3.14159265f;   // lux: a white surface that faces it then has radiance 1
  bool operator==(const SunLight&) const = default;
};

struct Settings {
  uint32_t width = 1280, height = 720;
  uint32_t stripPixels = 1u << 23;  // larger pictures are rendered in strips of at most so many: strips.h
  std::string layout = "compact";
  std::string normals = "octahedral";
  std::string normalSpace = "layout";
  std::string position = "ray";
  std::string lighting = "fullscreen";
  std::string shading = "ggx";
  std::string tonemap = "khronos";
  std::string volumesOrder = "classic";  // of the lighting technique `volumes`
  std::string transparency = "exact";    // how alpha-blended surfaces are drawn
  std::string dataSurfaces = "opaque";   // which surfaces data outputs show
  uint32_t superSampling = 1;            // N: N x N ordered samples a pixel, in N * N frames
  uint32_t samples = 1;                  // of the hardware's, a pixel: 1, or 4 (MSAA)
  bool everySample = false;              // all of those are shaded, alike or not: the reference of MSAA
  bool countSurfaces = false;            // fills Renderer::shadingCounts()
  bool temporal = false;                 // temporal anti-aliasing; not together with super-sampling
  std::optional<uint32_t> anisotropy;    // samples of a texture along a pixel's footprint; none: the device's usual
  float exposure = 0;                    // EV: radiance is multiplied by 2^exposure
  float environmentIntensity = 1;
  float environmentRotation = 0;  // radians about the up axis, +X towards +Z of the glTF frame
  // Shadows: shadow/plan.h.
  std::string shadows = "d32";        // how depth is stored; none: no shadows
  std::string shadowFilter = "pcf";   // how it becomes light
  std::string shadowLights = "auto";  // which lights cast them: auto, all, none, a number, or names by comma
  uint32_t shadowAtlas = 4096;        // side of the square that all maps have to fit in, texels
  float lightSize = 0.05f;            // metres: radius of point and spot lights that have none of their own, for pcss
  float sunAngle = 0.0093f;           // radians across: of directional lights that have none of their own, for pcss
  std::optional<SunLight> sun;        // beside the scene's lights

  Background background = Background::Transparent;
  glm::vec3 backgroundColor{0};  // linear display colour

  AmbientOcclusionSettings ao;
  BloomSettings bloom;
  FogSettings fog;
  bool fxaa = false;

  bool display = true;            // the tonemapped picture
  std::vector<output::Aov> aovs;  // beside it; Color is the linear picture
  NormalFrame normalFrame = NormalFrame::World;
  bool zUp = false;  // positions, normals and poses in the renderer's world instead of the scene file's frame
};

// The names that options take, each list in the order of its constants: kShading*, kTonemap*, kVolumes*, kNormalSpace*,
// kPosition*, kTransparency*, kShadow*, kShadowFilter*, kAo*, kBloom*.
struct NamedOption {
  const char* name;
  const char* description;
};
const std::vector<NamedOption>& shadings();
const std::vector<NamedOption>& tonemaps();
const std::vector<NamedOption>& volumesOrders();
const std::vector<NamedOption>& normalSpaces();
const std::vector<NamedOption>& positionMethods();
const std::vector<NamedOption>& ambientOcclusions();  // --ao, in the order of kAo*
const std::vector<NamedOption>& bloomFireflies();     // --bloom-fireflies, in the order of kBloom*
const std::vector<NamedOption>& postEffects();        // every effect, and the option that turns it on

// --aa by name: what each sets. ssN, for any N, is setAntiAliasing()'s own.
struct AntiAliasing {
  const char* name;
  const char* description;
  void (*set)(Settings&);
};
const std::vector<AntiAliasing>& antiAliasings();
void setAntiAliasing(Settings& settings, const std::string& name);  // throws Error(Usage)
const std::vector<NamedOption>& transparencies();
const std::vector<NamedOption>& dataSurfaces();
const std::vector<NamedOption>& shadowFormats();
const std::vector<NamedOption>& shadowFilters();

// Throws Error(Usage) with a sentence where a value is out of range or a name unknown.
void checkSettings(const Settings& settings);

}  // namespace latelight::render
