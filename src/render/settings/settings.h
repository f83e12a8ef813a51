// The settings of a picture: the options of `latelight render`, as data. The table of options
// (include/latelight/options.def) lists them; here they have the renderer's own types.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "output/aov.h"
#include "render/settings/sensor_options.h"
#include "scene/aperture.h"

namespace latelight::render {

struct Layout;
struct NormalEncoding;
struct TechniqueInfo;

// A name that an option accepts, and its description.
struct NamedOption {
  const char* name;
  const char* description;
};

// One enumeration per OPTION_CHOICE, numbered like the shaders' constants for it.
#define OPTION_CHOICE(Enum, member, name, defaultValue, topic, effect, help, ...) \
  enum class Enum : uint32_t { __VA_ARGS__ };
#define OPTION_NAME(constant, name, description) constant,
#include <latelight/options.def>

// The names of the enumeration, in order.
template <typename Enum>
inline constexpr std::span<const NamedOption> kChoices{};
#define OPTION_CHOICE(Enum, member, name, defaultValue, topic, effect, help, ...) \
  inline constexpr NamedOption kNamesOf##Enum[] = {__VA_ARGS__};                  \
  template <>                                                                     \
  inline constexpr std::span<const NamedOption> kChoices<Enum> = kNamesOf##Enum;
#define OPTION_NAME(constant, name, description) {name, description},
#include <latelight/options.def>

template <typename Enum>
constexpr std::span<const NamedOption> choices() {
  static_assert(!kChoices<Enum>.empty(), "not the enumeration of an option");
  return kChoices<Enum>;
}

// Returns the value that shaders switch on.
template <typename Enum>
constexpr uint32_t indexOf(Enum choice) {
  return static_cast<uint32_t>(choice);
}
template <typename Enum>
constexpr const char* nameOf(Enum choice) {
  return choices<Enum>()[indexOf(choice)].name;
}

// Returns the choice with that name, if there is one.
template <typename Enum>
constexpr std::optional<Enum> choiceNamed(std::string_view name) {
  const std::span<const NamedOption> all = choices<Enum>();
  for (uint32_t i = 0; i < all.size(); ++i)
    if (name == all[i].name) return static_cast<Enum>(i);
  return std::nullopt;
}

using Color = glm::vec3;  // linear, in the display's primaries
using scene::Aperture;

// The background of a picture.
struct Background {
  enum Kind { Transparent, Color, Environment };
  Kind kind = Transparent;
  render::Color color{0};
  bool operator==(const Background&) const = default;
};

// A directional light. Azimuth and elevation are the direction it comes from, with the angles of an orbiting camera.
struct SunLight {
  float azimuth = 0, elevation = 0;  // radians
  float illuminance = 3.14159265f;   // lux: a white surface that faces it then has radiance 1
  bool operator==(const SunLight&) const = default;
};

inline constexpr int kMaxExposure = 60;  // EV, in both directions
bool isValidExposure(double ev);         // false for values that are not finite

// The exposure of a picture: radiance is multiplied by 2^ev and, if automatic, by the factor of submit/metering.h.
struct Exposure {
  float ev = 0;
  bool automatic = false;
  Exposure() = default;
  Exposure(float ev, bool automatic = false) : ev(ev), automatic(automatic) {}
  bool operator==(const Exposure&) const = default;
};

inline constexpr uint32_t kMaxSuperSampling = 16;
// How a pixel is sampled. At most one of the first three members differs from its default.
struct AntiAliasing {
  uint32_t superSampling = 1;  // N: N x N ordered samples per pixel, in N * N frames
  uint32_t samples = 1;        // per pixel: 1, 2, 4, 8 or 16; each surface is shaded once (MSAA)
  bool temporal = false;       // each frame is blended into the earlier ones (TAA)
  bool fxaa = false;           // the finished picture's edges are softened
  bool operator==(const AntiAliasing&) const = default;
};

// The modes of --aa by name, and the settings of each. ssN stands for any N.
struct AntiAliasingMode {
  const char* name;
  const char* description;
  std::optional<AntiAliasing> sets;
};
std::span<const AntiAliasingMode> antiAliasingModes();

// The lights that may cast shadows (shadow/choose.h).
struct ShadowLights {
  static constexpr uint32_t kAll = std::numeric_limits<uint32_t>::max();
  bool automatic = true;           // the few most important lights
  uint32_t most = kAll;            // if not automatic: the maximum number of lights
  std::vector<std::string> names;  // names of the lights that may cast them; empty: any light
  bool operator==(const ShadowLights&) const = default;
};

// The point that the output `position` is relative to, in the axes of that output, meters.
struct PositionOrigin {
  glm::dvec3 point{0};
  bool operator==(const PositionOrigin&) const = default;
};

// Parse the value of an option. Each throws Error(Usage) with a message that begins with the option's name.
uint32_t readChoiceIndex(const char* option, std::span<const NamedOption> names, std::string_view text);
template <typename Enum>
Enum readChoice(const char* option, std::string_view text) {
  return static_cast<Enum>(readChoiceIndex(option, choices<Enum>(), text));
}
template <typename Entry>
const Entry& readEntry(const char* option, std::string_view name);
template <>
const Layout& readEntry<Layout>(const char* option, std::string_view name);
template <>
const NormalEncoding& readEntry<NormalEncoding>(const char* option, std::string_view name);
template <>
const TechniqueInfo& readEntry<TechniqueInfo>(const char* option, std::string_view name);  // options/options.cpp
template <typename T>
T readText(const char* option, std::string_view text);
template <>
std::string readText<std::string>(const char* option, std::string_view text);
template <>
Color readText<Color>(const char* option, std::string_view text);  // "#rrggbb" or "r,g,b", sRGB
template <>
Background readText<Background>(const char* option, std::string_view text);
template <>
AntiAliasing readText<AntiAliasing>(const char* option, std::string_view text);
template <>
Aperture readText<Aperture>(const char* option, std::string_view text);  // "pinhole", "f/2.8" or a radius in meters
template <>
Vignetting readText<Vignetting>(const char* option, std::string_view text);
template <>
WhiteBalance readText<WhiteBalance>(const char* option, std::string_view text);
template <>
Response readText<Response>(const char* option, std::string_view text);
template <>
ShadowLights readText<ShadowLights>(const char* option, std::string_view text);
template <>
PositionOrigin readText<PositionOrigin>(const char* option, std::string_view text);  // "x,y,z"
template <>
SunLight readText<SunLight>(const char* option, std::string_view text);  // "az,el[,lux]", degrees
template <>
Exposure readText<Exposure>(const char* option, std::string_view text);  // "1.5", "auto", "auto+0.5" or "auto-1"
std::pair<uint32_t, uint32_t> readSize(const char* option, std::string_view text);  // "1280x720"

inline float radians(double degrees) {
  return static_cast<float>(degrees * 3.14159265358979323846 / 180.0);
}

// The form of outputs that stay on the device as arrays. Others have 32 bits per element, or 8 bits for the picture.
struct ExportFormats {
  bool rgb = false;                  // the picture has no alpha channel
  std::vector<output::Aov> shorter;  // outputs with 16 bits per element: half floats, or 16-bit ids
  bool channelsFirst = false;        // one plane per channel
  bool operator==(const ExportFormats&) const = default;
};

// The members are those of latelight::Options, with angles in radians.
struct Settings {
#define OPTION_FLAG(member, ...) bool member = false;
#define OPTION_NUMBER(Type, member, name, defaultValue, ...) Type member = defaultValue;
#define OPTION_ANGLE(member, name, defaultValue, ...) float member = radians(defaultValue);
#define OPTION_OPTIONAL(Type, member, ...) std::optional<Type> member;
#define OPTION_CHOICE(Enum, member, name, defaultValue, ...) Enum member = choiceNamed<Enum>(defaultValue).value();
#define OPTION_ENTRY(Type, member, name, defaultValue, ...) const Type* member = &readEntry<Type>(name, defaultValue);
#define OPTION_TEXT(Type, member, name, defaultValue, ...) Type member = readText<Type>(name, defaultValue);
#define OPTION_SIZE(width, height, name, defaultWidth, defaultHeight, ...) \
  uint32_t width = defaultWidth, height = defaultHeight;
#define OPTION_SUN(member, ...) std::optional<SunLight> member;
#define OPTION_EXPOSURE(member, ...) Exposure member;
#include <latelight/options.def>

  // Settings without an option.
  bool display = true;              // the tonemapped picture
  std::vector<output::Aov> aovs;    // in addition; Color is the linear picture
  uint32_t stripPixels = 1u << 23;  // larger pictures are rendered in strips of at most this many pixels (strips.h)
  bool everySample = false;         // reference: MSAA shades all samples, even if they are alike
  bool wholeShadowMaps = false;     // reference: shadow maps are drawn in full, not only the pages that are looked up
  bool countSurfaces = false;       // fills RenderStatistics::shadingCounts
  bool describeGraph = false;       // fills RenderStatistics::graphviz
  ExportFormats exports;            // for Results::Exported
  bool operator==(const Settings&) const = default;
};

// Returns the factor for radiance; with an automatic exposure, only that of the compensation.
float exposureFactor(const Settings& settings);
// Returns true if these settings use the graphics pipeline regardless of the raster: for techniques that draw the scene
// and, with several samples per pixel, for those that draw lights.
bool alwaysDraws(const Settings& settings);
// Returns true if visible surfaces are lit without a G-buffer in between.
bool lightsTriangles(const Settings& settings);
// Returns true if these settings require the raster compute. The graphics pipeline supports only one or four samples
// per pixel, and it stores no triangles to light.
bool takesCompute(const Settings& settings);
// Returns true if frames with these settings find the visible surfaces in compute shaders.
bool rastersInCompute(const Settings& settings);
// Returns true if they find them by rays.
bool tracesVisibility(const Settings& settings);

// Returns true if the filter of indirect light averages over the frames of a sequence.
bool keepsIndirect(const Settings& settings);
// Returns true if a frame of a sequence depends on earlier ones.
bool keepsHistory(const Settings& settings);

// Returns every post-processing effect and the option that enables it.
std::span<const NamedOption> postEffects();

}  // namespace latelight::render
