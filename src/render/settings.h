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
  bool temporal = false;                 // temporal anti-aliasing; not together with super-sampling
  float exposure = 0;                    // EV: radiance is multiplied by 2^exposure
  float environmentIntensity = 1;
  float environmentRotation = 0;  // radians about the up axis, +X towards +Z of the glTF frame
  Background background = Background::Transparent;
  glm::vec3 backgroundColor{0};  // linear display colour

  bool display = true;            // the tonemapped picture
  std::vector<output::Aov> aovs;  // beside it; Color is the linear picture
  NormalFrame normalFrame = NormalFrame::World;
  bool zUp = false;  // positions, normals and poses in the renderer's world instead of the scene file's frame
};

// The names --shading, --tonemap, --volumes-order, --normal-space and --position take, in the order of their kShading*,
// kTonemap*, kVolumes*, kNormalSpace* and kPosition* constants.
struct NamedOption {
  const char* name;
  const char* description;
};
const std::vector<NamedOption>& shadings();
const std::vector<NamedOption>& tonemaps();
const std::vector<NamedOption>& volumesOrders();
const std::vector<NamedOption>& normalSpaces();
const std::vector<NamedOption>& positionMethods();

// Throws Error(Usage) with a sentence where a value is out of range or a name unknown.
void checkSettings(const Settings& settings);

}  // namespace latelight::render
