#include "render/options/options.h"

#include <algorithm>
#include <bit>

#include "base/error.h"
#include "render/base/registry.h"
#include "render/gbuffer/layout.h"
#include "render/lighting/technique.h"
#include "render/options/option_table.h"
#include "shared/samples.h"

namespace latelight::render {

namespace {

template <typename Range>
std::vector<NamedOption> describedIn(const Range& registry) {
  std::vector<NamedOption> names;
  for (const auto& entry : registry) names.push_back({entry.name.c_str(), entry.description});
  return names;
}

template <typename Entry>
std::vector<NamedOption> entriesOf();
template <>
std::vector<NamedOption> entriesOf<Layout>() {
  return describedIn(layouts());
}
template <>
std::vector<NamedOption> entriesOf<NormalEncoding>() {
  return describedIn(normalEncodings());
}
template <>
std::vector<NamedOption> entriesOf<TechniqueInfo>() {
  return describedIn(allTechniques());
}

}  // namespace

template <>
const TechniqueInfo& readEntry<TechniqueInfo>(const char* option, std::string_view name) {
  return entryNamed(option, allTechniques(), name);
}

template <>
std::vector<NamedOption> namesOfText<AntiAliasing>() {
  std::vector<NamedOption> names;
  for (const AntiAliasingMode& mode : antiAliasingModes()) names.push_back({mode.name, mode.description});
  return names;
}

template <>
void checkText<AntiAliasing>(const Option& option, const AntiAliasing& aa) {
  if (aa.superSampling < 1 || aa.superSampling > kMaxSuperSampling)
    badUsage("{}: supersampling requires 1 to {} samples along each axis, not {}", option.name, kMaxSuperSampling,
             aa.superSampling);
  if (aa.samples > shared::kMaxSamples || !std::has_single_bit(aa.samples))
    badUsage("{}: multisampling requires 1, 2, 4, 8 or 16 samples per pixel, not {}", option.name, aa.samples);
  if ((aa.samples > 1) + (aa.superSampling > 1) + aa.temporal > 1)
    badUsage("{}: multisampling, supersampling and temporal anti-aliasing cannot be combined; use one", option.name);
}

template <>
void checkText<Color>(const Option& option, const Color& color) {
  constexpr float kMax = 65504;  // the largest half float
  for (int i = 0; i < 3; ++i)
    if (!between(0, kMax).holds(color[i]))
      badUsage("{} takes channels from 0 to {}, not {}", option.name, kMax, color[i]);
}

template <>
void checkText<Background>(const Option& option, const Background& background) {
  checkText(option, background.color);
}

namespace {

void addSize(OptionTable<Settings>& table, Option option, uint32_t width, uint32_t height, uint32_t most) {
  option.defaultValue = fmt::format("{}x{}", width, height);
  option.range = between(1, most);
  option.unit = "pixels a side";
  table.add(
      option,
      [](Settings& s, const Option& o, std::string_view text) {
        std::tie(s.width, s.height) = readSize(o.name, text);
        return fmt::format("{}x{}", s.width, s.height);
      },
      [](const Settings& s, const Option& o) {
        if (!o.range.holds(s.width) || !o.range.holds(s.height))
          badUsage("{} takes a width and a height from {}, not {}x{}", o.name, rangeText(o), s.width, s.height);
      });
}

void addSun(OptionTable<Settings>& table, Option option) {
  option.without = "none";
  table.add(
      option,
      [](Settings& s, const Option& o, std::string_view text) {
        s.sun = readText<SunLight>(o.name, text);
        return std::string(text);
      },
      [](const Settings& s, const Option& o) {
        if (!s.sun) return;
        if (!std::isfinite(s.sun->azimuth) || !std::isfinite(s.sun->elevation))
          badUsage("{} requires an azimuth and elevation in degrees", o.name);
        if (!atLeast(0).holds(s.sun->illuminance))
          badUsage("{} requires at least 0 lux, not {}", o.name, s.sun->illuminance);
      });
}

void addExposure(OptionTable<Settings>& table, Option option) {
  option.defaultValue = "0";
  table.add(
      option,
      [](Settings& s, const Option& o, std::string_view text) {
        s.exposure = readText<Exposure>(o.name, text);
        return s.exposure.automatic ? std::string(text) : fmt::format("{}", s.exposure.ev);
      },
      [](const Settings& s, const Option& o) {
        if (!isValidExposure(s.exposure.ev))
          badUsage("{} takes a number from -{} to {} EV, not \"{}\"", o.name, kMaxExposure, kMaxExposure,
                   s.exposure.ev);
      });
}

const OptionTable<Settings>& table() {
  static const OptionTable<Settings> made = [] {
    using S = Settings;
    OptionTable<S> t;
#define ROW(M, N, E, H)                                           \
  Option {                                                        \
    .name = N, .member = #M, .effect = OptionEffect::E, .help = H \
  }
#define OPTION_GROUP(title) t.group(title);
#define OPTION_FLAG(member, name, effect, help) t.flag(&S::member, ROW(member, name, effect, help));
#define OPTION_NUMBER(Type, member, name, defaultValue, range, unit, effect, help) \
  t.number<Type>(&S::member, ROW(member, name, effect, help), defaultValue, range, unit);
#define OPTION_ANGLE(member, name, defaultValue, range, effect, help) \
  t.angle(&S::member, ROW(member, name, effect, help), defaultValue, range);
#define OPTION_OPTIONAL(Type, member, name, range, unit, without, effect, help) \
  t.optional<Type>(&S::member, ROW(member, name, effect, help), range, unit, without);
#define OPTION_CHOICE(Enum, member, name, defaultValue, topic, effect, help, ...) \
  t.choice(&S::member, ROW(member, name, effect, help), defaultValue, topic);
#define OPTION_ENTRY(Type, member, name, defaultValue, topic, effect, help) \
  t.entry(&S::member, ROW(member, name, effect, help), defaultValue, topic, entriesOf<Type>());
#define OPTION_TEXT(Type, member, name, defaultValue, topic, effect, help) \
  t.text(&S::member, ROW(member, name, effect, help), defaultValue, topic);
#define OPTION_SIZE(width, height, N, defaultWidth, defaultHeight, most, H) \
  addSize(t, Option{.name = N, .member = #width ", " #height, .help = H}, defaultWidth, defaultHeight, most);
#define OPTION_SUN(member, name, help) addSun(t, ROW(member, name, Runtime, help));
#define OPTION_EXPOSURE(member, name, help) addExposure(t, ROW(member, name, Runtime, help));
#include <latelight/options.def>
#undef ROW
    return t;
  }();
  return made;
}

}  // namespace

std::string_view longName(const Option& option) {
  const std::string_view name = option.name;
  return name.substr(name.find(',') + 1);  // the full name if there is no comma
}

std::string_view keyOf(const Option& option) {
  const std::string_view name = longName(option);
  return name.substr(std::min(name.find_first_not_of('-'), name.size()));
}

std::string rangeText(const Option& option) {
  const Range& r = option.range;
  const auto text = [](double value) {
    return value == std::floor(value) ? fmt::format("{:.0f}", value) : fmt::format("{:g}", value);
  };
  std::string range;
  if (std::isfinite(r.least) && std::isfinite(r.most))
    range = text(r.least) + " to " + text(r.most);
  else if (std::isfinite(r.least))
    range = (r.open ? "above " : "at least ") + text(r.least);
  return range + (range.empty() || option.unit.empty() ? "" : " ") + option.unit;
}

void refuse(const Option& option, std::string_view given) {
  const std::string range = rangeText(option);
  const bool both = std::isfinite(option.range.least) && std::isfinite(option.range.most);
  const char* before = range.empty() ? "" : both ? " from " : option.range.open ? " " : " of ";
  badUsage("{} takes a {}{}{}, not \"{}\"", longName(option),
           option.kind == OptionKind::Integer ? "whole number" : "number", before, range, given);
}

std::span<const Option> options() {
  return table().options();
}

const Range& rangeOf(std::string_view name) {
  const auto option = std::ranges::find(options(), name, &Option::name);
  if (option == options().end()) fail(ExitCode::Internal, "There is no option {}.", name);
  return option->range;
}

std::string read(Settings& settings, const Option& option, std::string_view text) {
  return table().read(settings, option, text);
}

namespace {

void checkPaths(const Settings& settings) {
  const bool indirect = settings.indirect != Indirect::None;
  if (indirect && settings.lighting->forward)
    badUsage("--indirect requires a deferred technique, unlike {}", settings.lighting->name);
  if (keepsIndirect(settings) && settings.aa.superSampling > 1)
    badUsage("--indirect-filter temporal does not support --aa ss{}, whose samples are frames of their own: use taa",
             settings.aa.superSampling);
  const bool rays = settings.shadows == ShadowFormat::Rays && !settings.lighting->traces;
  if (rays && settings.lighting->forward)
    badUsage("--shadows rays requires a deferred technique, unlike {}", settings.lighting->name);
  if (rays && settings.aa.samples > 1)
    badUsage("--aa msaa{} does not sample --shadows rays: use --aa ss2 or more", settings.aa.samples);
  if ((indirect || settings.lighting->traces) && settings.aa.samples > 1)
    badUsage("--aa msaa{} does not sample the paths of {}: use --aa ss2 or more", settings.aa.samples,
             indirect ? "--indirect" : "--lighting reference");
  if (settings.ground != Ground::None && settings.aa.samples > 1)
    badUsage("--aa msaa{} does not sample --ground: use --aa ss2 or more", settings.aa.samples);
}

}  // namespace

void checkSettings(const Settings& settings) {
  table().check(settings);
  checkPaths(settings);
  if (settings.apertureBlades == 1 || settings.apertureBlades == 2)
    badUsage("--aperture-blades takes 0 for a circle, or at least 3 blades, not {}", settings.apertureBlades);
  if (!takesCompute(settings)) return;
  const bool triangles = lightsTriangles(settings);
  if (triangles && settings.lighting->draws)
    badUsage("--layout {} has no G-buffer for {} lighting: choose {}", settings.layout->name, settings.lighting->name,
             techniquesThatCompute());
  if (triangles && settings.raster == Raster::Hardware)
    badUsage(
        "--layout {} requires the raster compute; to light without a G-buffer with hardware, use --lighting forward",
        settings.layout->name);
  if (settings.lighting->draws)
    badUsage("--aa msaa{} requires lighting that runs in compute, unlike {}: choose another, or msaa4",
             settings.aa.samples, settings.lighting->name);
  if (settings.raster == Raster::Hardware)
    badUsage("--aa msaa{} requires the raster compute, because hardware supports only msaa4", settings.aa.samples);
}

void checkLayoutOptions(const Settings& settings, const std::map<std::string, std::string, std::less<>>& given) {
  const Layout& layout = *settings.layout;
  if (given.contains("normals") && layout.fixedNormal)
    badUsage("--normals does not apply to the layout {}, which stores normals as {}", layout.name, layout.fixedNormal);
  if (given.contains("position") && layout.fixedPosition)
    badUsage("--position does not apply to the layout {}, which stores positions as {}", layout.name,
             layout.fixedPosition);
}

bool playsWithoutTime(const Settings& settings) {
  return !settings.time && (!settings.animation.empty() || settings.loop);
}

}  // namespace latelight::render
