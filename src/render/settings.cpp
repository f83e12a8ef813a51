#include "render/settings.h"

#include <cmath>

#include "base/error.h"
#include "base/text.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/registry.h"

namespace latelight::render {

const std::vector<NamedOption>& shadings() {
  static const std::vector<NamedOption> all = {
      {"ggx", "metallic-roughness of the glTF 2.0 specification: Trowbridge-Reitz, Smith, Schlick"},
      {"blinn-phong", "normalised Blinn-Phong with specular colour and exponent"},
      {"ggx-compensated", "ggx with the light that microfacets pass on to each other, under lights too"},
  };
  return all;
}

const std::vector<NamedOption>& tonemaps() {
  static const std::vector<NamedOption> all = {
      {"khronos", "Khronos PBR neutral: base colours stay true"},
      {"aces", "ACES filmic (Hill's fit of RRT and ODT)"},
      {"agx", "AgX (Sobotka), base look"},
      {"reinhard", "Reinhard on luminance"},
      {"none", "clamped to [0, 1]"},
  };
  return all;
}

const std::vector<NamedOption>& volumesOrders() {
  static const std::vector<NamedOption> all = {
      {"classic", "mark where a volume's back faces fail the depth test; light what is marked, at any depth"},
      {"killzone", "mark where they pass the reversed test; light what is marked and lies behind the front faces"},
  };
  return all;
}

const std::vector<NamedOption>& normalSpaces() {
  static const std::vector<NamedOption> all = {
      {"layout", "the layout's own"},
      {"world", "world space; not for encodings of the near hemisphere alone, which stay in view space"},
      {"view", "view space, the encoding's +Z towards the viewer"},
  };
  return all;
}

const std::vector<NamedOption>& positionMethods() {
  static const std::vector<NamedOption> all = {
      {"ray", "the view ray times view depth B / (d - A)"},
      {"matrix", "the full inverse projection matrix, and a division by w"},
      {"reciprocal", "the view ray times 1 / (P d + Q): a multiply-add and a reciprocal"},
  };
  return all;
}

const std::vector<NamedOption>& shadowFormats() {
  static const std::vector<NamedOption> all = {
      {"none", "no light casts shadows"},
      {"d32", "a depth image of 32-bit floats"},
      {"d16", "a depth image of 16 bits: half the memory"},
      {"rgba8", "four bytes of a colour image: the float's own 32 bits, no error"},
      {"rgba8-classic", "four bytes as EncodeFloatRGBA has them: digits to base 255, 2e-7 off, and 1 becomes 0"},
  };
  return all;
}

const std::vector<NamedOption>& shadowFilters() {
  static const std::vector<NamedOption> all = {
      {"hard", "the one texel that holds the point: edges as the texels are"},
      {"pcf", "nine comparisons, weighted by a quadratic B-spline 3 texels wide"},
      {"pcss", "as wide as the light's own size makes it: 16 comparisons to find what blocks, 64 to filter"},
  };
  return all;
}

const std::vector<NamedOption>& transparencies() {
  static const std::vector<NamedOption> all = {
      {"exact", "every fragment kept and sorted in its pixel: right for any number of layers in any order"},
      {"sorted", "objects from far to near: right where they do not interpenetrate and each is convex"},
      {"weighted", "no order: coverage is right, colours of several layers are a weighted mean"},
      {"none", "blended surfaces are left out"},
  };
  return all;
}

const std::vector<NamedOption>& dataSurfaces() {
  static const std::vector<NamedOption> all = {
      {"opaque", "the nearest surface that is not alpha-blended"},
      {"any", "the nearest surface of all: blended ones count where their alpha is above 0"},
  };
  return all;
}

const std::vector<NamedOption>& ambientOcclusions() {
  static const std::vector<NamedOption> all = {
      {"none", "the sky is hidden by material textures alone"},
      {"gtao", "ground-truth ambient occlusion: horizons in the depth buffer, cosine-weighted (Jimenez et al. 2016)"},
  };
  return all;
}

const std::vector<NamedOption>& bloomFireflies() {
  static const std::vector<NamedOption> all = {
      {"damp", "lone bright pixels glow less (Karis average), so that they don't flicker; some light is lost"},
      {"keep", "every pixel glows by its light: no light is lost"},
  };
  return all;
}

const std::vector<NamedOption>& postEffects() {
  static const std::vector<NamedOption> all = {
      {"ambient-occlusion", "--ao gtao: corners and contacts get less light from the environment"},
      {"fog", "--fog DENSITY: a medium, uniform or falling off with height, between the camera and what it sees"},
      {"bloom", "--bloom STRENGTH: bright places glow"},
      {"fxaa", "--aa fxaa: jagged edges of the finished picture are softened"},
  };
  return all;
}

const std::vector<AntiAliasing>& antiAliasings() {
  static const std::vector<AntiAliasing> all = {
      {"none", "one sample a pixel, at its centre", [](Settings&) {}},
      {"fxaa", "one sample a pixel; jagged edges are found in the finished picture and softened",
       [](Settings& s) { s.fxaa = true; }},
      {"msaa4", "multisampling: four samples a pixel, each surface of a pixel shaded once",
       [](Settings& s) { s.samples = 4; }},
      {"taa", "temporal: each frame of a sequence blended into the ones before; a still is the mean of 16 frames",
       [](Settings& s) { s.temporal = true; }},
      {"ssN", "super-sampling: N x N ordered samples a pixel, as in ss2 or ss4", nullptr},
  };
  return all;
}

void setAntiAliasing(Settings& settings, const std::string& name) {
  for (const AntiAliasing& aa : antiAliasings())
    if (aa.set && name == aa.name) return aa.set(settings);
  if (name.starts_with("ss")) {
    const auto n = parseNumber<uint32_t>(std::string_view(name).substr(2));
    if (n && *n >= 1 && *n <= 16) {
      settings.superSampling = *n;
      return;
    }
  }
  badUsage("--aa takes one of {}, with N from 1 to 16 as in ss4 or ss16, not \"{}\"", namesOf(antiAliasings()), name);
}

namespace {

// Throws where it is not a number from `least` to `most`.
void checkNumber(const char* what, float value, float least, float most) {
  if (!(value >= least && value <= most))
    badUsage("{} must be a number between {} and {}, not {}", what, least, most, value);
}

void checkPost(const Settings& s) {
  constexpr float kMany = 1e6f;  // metres, or fogs a metre: nothing larger shows anything
  findByName(ambientOcclusions(), s.ao.method, "ambient occlusion");
  if (s.ao.radius && !(*s.ao.radius > 0 && std::isfinite(*s.ao.radius)))
    badUsage("the radius of ambient occlusion must be a number of metres above 0, not {}", *s.ao.radius);
  checkNumber("the strength of ambient occlusion", s.ao.strength, 0, 10);
  checkNumber("the strength of bloom", s.bloom.strength, 0, 1);
  checkNumber("the radius of bloom", s.bloom.radius, 0, 1);
  checkNumber("the threshold of bloom", s.bloom.threshold, 0, 65504);
  findByName(bloomFireflies(), s.bloom.fireflies, "treatment of fireflies");
  checkNumber("the density of fog", s.fog.density, 0, kMany);
  for (int i = 0; i < 3; ++i) checkNumber("a channel of the fog's colour", s.fog.color[i], 0, 65504);
  checkNumber("the height in which fog thins out", s.fog.height, 0, kMany);
  checkNumber("the height at which fog has its density", s.fog.base, -kMany, kMany);
}

void checkShadows(const Settings& s) {
  findByName(shadowFormats(), s.shadows, "shadow format");
  findByName(shadowFilters(), s.shadowFilter, "shadow filter");
  constexpr uint32_t kLeast = 256, kMost = 16384;
  if (s.shadowAtlas < kLeast || s.shadowAtlas > kMost)
    badUsage("the shadow atlas's side must lie between {} and {} texels, not {}", kLeast, kMost, s.shadowAtlas);
  if (!std::isfinite(s.lightSize) || s.lightSize < 0)
    badUsage("the size of lights must be a number of metres of at least 0, not {}", s.lightSize);
  constexpr float kWidest = 1.5707964f;
  if (!(s.sunAngle >= 0 && s.sunAngle <= kWidest))
    badUsage("the angle that directional lights fill must lie between 0 and 90 degrees");
  if (!s.sun) return;
  if (!std::isfinite(s.sun->azimuth) || !std::isfinite(s.sun->elevation))
    badUsage("the sun's azimuth and elevation must be numbers of degrees");
  if (!std::isfinite(s.sun->illuminance) || s.sun->illuminance < 0)
    badUsage("the sun's illuminance must be a number of lux of at least 0, not {}", s.sun->illuminance);
}

}  // namespace

void checkSettings(const Settings& s) {
  constexpr uint32_t kMaxSide = 16384;  // maxImageDimension2D every Vulkan 1.3 device we know of offers
  if (s.width == 0 || s.height == 0 || s.width > kMaxSide || s.height > kMaxSide)
    badUsage("a picture of {}x{} pixels can't be made; each side must lie between 1 and {}", s.width, s.height,
             kMaxSide);
  if (s.superSampling < 1 || s.superSampling > 16)
    badUsage("super-sampling takes 1 to 16 samples along each side, not {}", s.superSampling);
  if (s.samples != 1 && s.samples != 4) badUsage("multisampling takes 1 or 4 samples a pixel, not {}", s.samples);
  if ((s.samples > 1) + (s.superSampling > 1) + s.temporal > 1)
    badUsage(
        "multisampling, super-sampling and temporal anti-aliasing each choose the samples of a pixel; use one of them");
  if (s.anisotropy && (*s.anisotropy < 1 || *s.anisotropy > 16))
    badUsage("anisotropic filters take 1 to 16 samples, not {}", *s.anisotropy);
  if (!std::isfinite(s.exposure) || std::abs(s.exposure) > 60)
    badUsage("the exposure must be a number between -60 and 60 EV, not {}", s.exposure);
  if (!std::isfinite(s.environmentIntensity) || s.environmentIntensity < 0)
    badUsage("the environment's intensity must be a number of at least 0, not {}", s.environmentIntensity);
  if (!std::isfinite(s.environmentRotation)) badUsage("the environment's rotation must be a number of degrees");
  checkShadows(s);
  checkPost(s);
  findLayout(s.layout);
  findNormalEncoding(s.normals);
  findByName(normalSpaces(), s.normalSpace, "space of normals");
  findByName(positionMethods(), s.position, "position method");
  findTechnique(s.lighting);
  findByName(shadings(), s.shading, "shading model");
  findByName(tonemaps(), s.tonemap, "tonemap");
  findByName(transparencies(), s.transparency, "method of transparency");
  findByName(dataSurfaces(), s.dataSurfaces, "choice of surfaces for data");
  findByName(volumesOrders(), s.volumesOrder, "order of light volumes");
}

}  // namespace latelight::render
