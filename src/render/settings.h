// What a picture is rendered with: the choices of `latelight render`, as data.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "output/aov.h"

namespace latelight::render {

enum class NormalFrame { World, OpenCv, OpenGl };  // of the normal and geonormal outputs
enum class Background { Transparent, Color, Environment };

// A directional light. Azimuth and elevation say where it comes from, as an orbiting camera's do.
struct SunLight {
  float azimuth = 0, elevation = 0;  // radians
  float illuminance = 3.14159265f;   // lux: a white surface that faces it then has radiance 1
  bool operator==(const SunLight&) const = default;
};

struct Settings {
  uint32_t width = 1280, height = 720;
  std::string layout = "thin";
  std::string normals = "octahedral";
  std::string normalSpace = "layout";
  std::string position = "ray";
  std::string lighting = "fullscreen";
  std::string shading = "ggx";
  std::string tonemap = "khronos";
  std::string volumesOrder = "classic";  // of the lighting technique `volumes`
  uint32_t superSampling = 1;            // N: N x N ordered samples a pixel, in N * N frames
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

  bool display = true;            // the tonemapped picture
  std::vector<output::Aov> aovs;  // beside it; Color is the linear picture
  NormalFrame normalFrame = NormalFrame::World;
  bool zUp = false;  // positions, normals and poses in the renderer's world instead of the scene file's frame
};

// The names --shading, --tonemap, --volumes-order, --normal-space, --position, --shadows and --shadow-filter take, in
// the order of their kShading*, kTonemap*, kVolumes*, kNormalSpace*, kPosition*, kShadow* and kShadowFilter* constants.
struct NamedOption {
  const char* name;
  const char* description;
};
const std::vector<NamedOption>& shadings();
const std::vector<NamedOption>& tonemaps();
const std::vector<NamedOption>& volumesOrders();
const std::vector<NamedOption>& normalSpaces();
const std::vector<NamedOption>& positionMethods();
const std::vector<NamedOption>& shadowFormats();
const std::vector<NamedOption>& shadowFilters();

// Throws Error(Usage) with a sentence where a value is out of range or a name unknown.
void checkSettings(const Settings& settings);

}  // namespace latelight::render
