#include "render/settings/settings.h"

#include <charconv>
#include <cmath>

#include "base/error.h"
#include "base/text.h"
#include "render/base/registry.h"
#include "render/gbuffer/layout.h"
#include "render/settings/technique_info.h"
#include "shared/color.h"
#include "shared/rays.h"
#include "shared/shade.h"
#include "shared/shadow.h"
#include "shared/tonemap.h"

namespace latelight::render {

// The enumerations equal the constants that shaders switch on.
static_assert(indexOf(Tonemap::Khronos) == shared::kTonemapKhronosNeutral);
static_assert(indexOf(Tonemap::Aces) == shared::kTonemapAces);
static_assert(indexOf(Tonemap::Agx) == shared::kTonemapAgx);
static_assert(indexOf(Tonemap::Reinhard) == shared::kTonemapReinhard);
static_assert(indexOf(Tonemap::None) == shared::kTonemapNone);
static_assert(indexOf(Shading::Ggx) == shared::kShadingGgx);
static_assert(indexOf(Shading::BlinnPhong) == shared::kShadingBlinnPhong);
static_assert(indexOf(Shading::GgxCompensated) == shared::kShadingGgxCompensated);
static_assert(indexOf(NormalSpace::Layout) == shared::kNormalSpaceLayout);
static_assert(indexOf(NormalSpace::World) == shared::kNormalSpaceWorld);
static_assert(indexOf(NormalSpace::View) == shared::kNormalSpaceView);
static_assert(indexOf(PositionMethod::Ray) == shared::kPositionRay);
static_assert(indexOf(PositionMethod::Matrix) == shared::kPositionMatrix);
static_assert(indexOf(PositionMethod::Reciprocal) == shared::kPositionReciprocal);
static_assert(indexOf(ShadowFormat::None) == shared::kShadowNone);
static_assert(indexOf(ShadowFormat::D32) == shared::kShadowD32);
static_assert(indexOf(ShadowFormat::D16) == shared::kShadowD16);
static_assert(indexOf(ShadowFormat::Rgba8) == shared::kShadowRgba8);
static_assert(indexOf(ShadowFormat::Rgba8Classic) == shared::kShadowRgba8Classic);
static_assert(indexOf(ShadowFormat::Rays) == shared::kShadowRays);
static_assert(indexOf(Indirect::OneBounce) == shared::kIndirectOneBounce);
static_assert(indexOf(Indirect::Path) == shared::kIndirectPath);
static_assert(indexOf(ShadowFilter::Hard) == shared::kShadowFilterHard);
static_assert(indexOf(ShadowFilter::Pcf) == shared::kShadowFilterPcf);
static_assert(indexOf(ShadowFilter::Pcss) == shared::kShadowFilterPcss);

namespace {

// Parses two hexadecimal digits as a fraction of 255.
std::optional<float> channelIn(std::string_view digits) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return static_cast<float>(value) / 255.0f;
}

// Parses "#rrggbb" or "r,g,b" in sRGB, and returns linear values.
std::optional<Color> colorIn(std::string_view text) {
  std::vector<float> code;
  if (text.size() == 7 && text[0] == '#')
    for (size_t i = 1; i < 7; i += 2) code.push_back(channelIn(text.substr(i, 2)).value_or(-1.0f));
  else
    code = parseNumbers(text);
  if (code.size() != 3) return std::nullopt;
  Color color;
  for (int i = 0; i < 3; ++i) {
    if (!(code[i] >= 0 && code[i] <= 1)) return std::nullopt;
    color[i] = shared::linearFromSrgb(code[i]);
  }
  return color;
}

}  // namespace

uint32_t readChoiceIndex(const char* option, std::span<const NamedOption> names, std::string_view text) {
  return static_cast<uint32_t>(&entryNamed(option, names, text) - names.data());
}

template <>
const Layout& readEntry<Layout>(const char* option, std::string_view name) {
  return entryNamed(option, layouts(), name);
}

template <>
const NormalEncoding& readEntry<NormalEncoding>(const char* option, std::string_view name) {
  return entryNamed(option, normalEncodings(), name);
}

template <>
std::string readText<std::string>(const char*, std::string_view text) {
  return std::string(text);
}

template <>
Color readText<Color>(const char* option, std::string_view text) {
  const std::optional<Color> color = colorIn(text);
  if (!color) badUsage("{} takes #rrggbb, or r,g,b between 0 and 1, not \"{}\"", option, text);
  return *color;
}

template <>
Background readText<Background>(const char* option, std::string_view text) {
  if (text == "transparent") return {};
  if (text == "hdri") return {.kind = Background::Environment};
  const std::optional<Color> color = colorIn(text);
  if (!color) badUsage("{} takes transparent, hdri, #rrggbb, or r,g,b between 0 and 1, not \"{}\"", option, text);
  return {.kind = Background::Color, .color = *color};
}

std::span<const AntiAliasingMode> antiAliasingModes() {
  static const AntiAliasingMode all[] = {
      {"none", "one sample per pixel, at its center", AntiAliasing{}},
      {"fxaa", "one sample per pixel; softens aliased edges in the finished image", AntiAliasing{.fxaa = true}},
      {"msaa2", "multisampling: two samples per pixel, shaded once per visible surface (raster compute)",
       AntiAliasing{.samples = 2}},
      {"msaa4", "multisampling with four samples (either raster)", AntiAliasing{.samples = 4}},
      {"msaa8", "multisampling with eight samples (raster compute)", AntiAliasing{.samples = 8}},
      {"msaa16", "multisampling with sixteen samples (raster compute)", AntiAliasing{.samples = 16}},
      {"taa", "temporal: blends each frame of a sequence into the history; a still is the mean of 16 frames",
       AntiAliasing{.temporal = true}},
      {"ssN", "supersampling: N x N ordered-grid samples per pixel, such as ss2 or ss4", std::nullopt},
  };
  return all;
}

template <>
AntiAliasing readText<AntiAliasing>(const char* option, std::string_view text) {
  for (const AntiAliasingMode& mode : antiAliasingModes())
    if (mode.sets && text == mode.name) return *mode.sets;
  if (text.starts_with("ss")) {
    const auto n = parseNumber<uint32_t>(text.substr(2));
    if (n && *n >= 1 && *n <= kMaxSuperSampling) return {.superSampling = *n};
  }
  badUsage("{} takes one of {}, with N from 1 to {} as in ss4 or ss16, not \"{}\"", option,
           namesOf(antiAliasingModes()), kMaxSuperSampling, text);
}

template <>
Aperture readText<Aperture>(const char* option, std::string_view text) {
  return scene::parseAperture(option, text);
}

template <>
ShadowLights readText<ShadowLights>(const char* option, std::string_view text) {
  if (text == "auto") return {};
  ShadowLights lights{.automatic = false};
  if (text == "all") return lights;
  if (text == "none") {
    lights.most = 0;
  } else if (const auto number = parseNumber<uint32_t>(text)) {
    lights.most = *number;
  } else {
    for (std::string_view name : splitAtCommas(text)) lights.names.emplace_back(name);
  }
  return lights;
}

template <>
PositionOrigin readText<PositionOrigin>(const char* option, std::string_view text) {
  const std::vector<double> v = parseNumbers<double>(text);
  const bool finite = std::ranges::all_of(v, [](double x) { return std::isfinite(static_cast<float>(x)); });
  if (v.size() != 3 || !finite)
    badUsage("{} takes three coordinates x,y,z in meters, as in 500000,0,-4600000, not \"{}\"", option, text);
  return {{v[0], v[1], v[2]}};
}

template <>
SunLight readText<SunLight>(const char* option, std::string_view text) {
  const std::vector<float> v = parseNumbers(text);
  if (v.size() != 2 && v.size() != 3)
    badUsage("{} takes azimuth,elevation[,lux] in degrees, as in 30,40 or 30,40,3, not \"{}\"", option, text);
  SunLight sun{.azimuth = v[0] * radians(1), .elevation = v[1] * radians(1)};
  if (v.size() == 3) sun.illuminance = v[2];
  return sun;
}

bool isValidExposure(double ev) {
  return std::abs(ev) <= kMaxExposure;
}

template <>
Exposure readText<Exposure>(const char* option, std::string_view text) {
  const bool automatic = text.starts_with("auto");
  std::string_view number = automatic ? text.substr(4) : text;
  if (automatic && number.empty()) return {0, true};
  const bool isSigned = number.starts_with('+') || number.starts_with('-');
  if (number.starts_with('+')) number.remove_prefix(1);
  const std::optional<double> ev = parseNumber<double>(number);
  if (ev && (isSigned || !automatic) && isValidExposure(*ev)) return {static_cast<float>(*ev), automatic};
  badUsage("{} takes a number from -{} to {} EV, auto, or auto with a compensation as in auto+1, not \"{}\"", option,
           kMaxExposure, kMaxExposure, text);
}

std::pair<uint32_t, uint32_t> readSize(const char* option, std::string_view text) {
  if (const size_t x = text.find('x'); x != std::string_view::npos) {
    const auto width = parseNumber<uint32_t>(text.substr(0, x)), height = parseNumber<uint32_t>(text.substr(x + 1));
    if (width && height) return {*width, *height};
  }
  badUsage("{} takes a width and a height in pixels, as in 1280x720, not \"{}\"", option, text);
}

std::span<const NamedOption> postEffects() {
  static const NamedOption all[] = {
      {"ambient-occlusion", "--ao gtao: darkens environment light in corners and at contacts"},
      {"fog", "--fog DENSITY: fog, uniform or decreasing with height"},
      {"bloom", "--bloom STRENGTH: makes bright areas glow"},
      {"fxaa", "--aa fxaa: softens aliased edges of the finished image"},
  };
  return all;
}

bool alwaysDraws(const Settings& settings) {
  return settings.lighting->forward || (settings.aa.samples > 1 && settings.lighting->draws);
}

bool lightsTriangles(const Settings& settings) {
  return !settings.layout->hasTargets() && !settings.lighting->forward;
}

bool takesCompute(const Settings& settings) {
  return (settings.aa.samples != 1 && settings.aa.samples != 4) || lightsTriangles(settings);
}

bool rastersInCompute(const Settings& settings) {
  const bool compute = settings.raster == Raster::Compute || settings.raster == Raster::Rays;
  return (compute || takesCompute(settings)) && !alwaysDraws(settings);
}

bool tracesVisibility(const Settings& settings) {
  return settings.raster == Raster::Rays && rastersInCompute(settings);
}

bool keepsIndirect(const Settings& settings) {
  return settings.indirect != Indirect::None && settings.indirectFilter == IndirectFilter::Temporal &&
         !settings.lighting->traces;
}

bool keepsHistory(const Settings& settings) {
  return settings.aa.temporal || keepsIndirect(settings);
}

float exposureFactor(const Settings& settings) {
  return std::exp2(settings.exposure.ev);
}

}  // namespace latelight::render
