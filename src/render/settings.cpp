#include "render/settings.h"

#include <cmath>

#include "base/error.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/registry.h"

namespace latelight::render {

const std::vector<NamedOption>& shadings() {
  static const std::vector<NamedOption> all = {
      {"ggx", "metallic-roughness of the glTF 2.0 specification: Trowbridge-Reitz, Smith, Schlick"},
      {"blinn-phong", "normalised Blinn-Phong with specular colour and exponent"},
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

void checkSettings(const Settings& s) {
  constexpr uint32_t kMaxSide = 16384;  // maxImageDimension2D every Vulkan 1.3 device we know of offers
  if (s.width == 0 || s.height == 0 || s.width > kMaxSide || s.height > kMaxSide)
    badUsage("a picture of {}x{} pixels can't be made; each side must lie between 1 and {}", s.width, s.height,
             kMaxSide);
  if (s.superSampling < 1 || s.superSampling > 16)
    badUsage("super-sampling takes 1 to 16 samples along each side, not {}", s.superSampling);
  if (s.temporal && s.superSampling > 1)
    badUsage("temporal anti-aliasing and super-sampling each choose the samples of a pixel; use one of them");
  if (!std::isfinite(s.exposure) || std::abs(s.exposure) > 60)
    badUsage("the exposure must be a number between -60 and 60 EV, not {}", s.exposure);
  if (!std::isfinite(s.environmentIntensity) || s.environmentIntensity < 0)
    badUsage("the environment's intensity must be a number of at least 0, not {}", s.environmentIntensity);
  if (!std::isfinite(s.environmentRotation)) badUsage("the environment's rotation must be a number of degrees");
  findLayout(s.layout);
  findNormalEncoding(s.normals);
  findByName(normalSpaces(), s.normalSpace, "space of normals");
  findByName(positionMethods(), s.position, "position method");
  findTechnique(s.lighting);
  findByName(shadings(), s.shading, "shading model");
  findByName(tonemaps(), s.tonemap, "tonemap");
  findByName(volumesOrders(), s.volumesOrder, "order of light volumes");
}

}  // namespace latelight::render
