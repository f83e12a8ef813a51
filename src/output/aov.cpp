#include "output/aov.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "base/error.h"
#include "base/text.h"

namespace latelight::output {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

#define UNBRACKETED(...) __VA_ARGS__
constexpr std::array<AovInfo, kAovCount> kAovs{{
#define OUTPUT(aov, name, channels, exrChannels, exr, png, background, unit, description, ...) \
  {Aov::aov, name, channels, {UNBRACKETED exrChannels}, ExrType::exr, PngCoding::png, background, unit, description},
#include "output/outputs.def"
}};

std::string names() {
  std::string text;
  for (const AovInfo& aov : kAovs) text += (text.empty() ? "" : ", ") + std::string(aov.name);
  return text;
}

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(' ');
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

}  // namespace

std::span<const AovInfo> aovs() {
  return kAovs;
}

const AovInfo& info(Aov aov) {
  const AovInfo& entry = kAovs[static_cast<size_t>(aov)];
  assert(entry.aov == aov);
  return entry;
}

const AovInfo* findAov(std::string_view name) {
  for (const AovInfo& aov : kAovs)
    if (aov.name == name) return &aov;
  return nullptr;
}

std::string ownNames(const AovInfo& aov, uint32_t channel) {
  return std::string(aov.exrChannels[channel]);
}

std::string_view nameOf(ExrType type) {
  switch (type) {
    case ExrType::Half:
      return "half";
    case ExrType::Float:
      return "float";
    case ExrType::Uint:
      return "uint";
  }
  return "";
}

std::string_view describe(PngCoding coding) {
  switch (coding) {
    case PngCoding::None:
      return "not supported";
    case PngCoding::Display:
      return "8-bit RGBA, tone-mapped, sRGB, straight alpha";
    case PngCoding::Srgb:
      return "8-bit RGB, clamped to [0, 1], sRGB";
    case PngCoding::Unit:
      return "16-bit, value * 65535; values are clamped to [0, 1]";
    case PngCoding::Signed:
      return "16-bit, (value * 0.5 + 0.5) * 65535; background is 0 0 0";
    case PngCoding::Millimetre:
      return "16-bit, millimeters; 0 is background, 65535 is that far or farther";
    case PngCoding::Fraction:
      return "16-bit, fractional parts of u and v * 65535; blue is 0";
    case PngCoding::Count:
      return "16-bit; 65535 is that many or more";
    case PngCoding::IdBytes:
      return "8-bit RGBA, bytes of the integer: R + 256 G + 65536 B + 16777216 A";
  }
  return "";
}

bool contains(std::span<const Aov> aovs, Aov aov) {
  return std::find(aovs.begin(), aovs.end(), aov) != aovs.end();
}

bool holdsIntegers(Aov aov) {
  return info(aov).exr == ExrType::Uint;
}

bool holdsIds(Aov aov) {
  return aov == Aov::Id || aov == Aov::Part || aov == Aov::Material;
}

bool dependsOnNeighbors(Aov aov) {
  return aov == Aov::Motion || aov == Aov::SceneFlow;
}

bool tellsOfRaster(Aov aov) {
  return info(aov).name.starts_with("raster-");
}

std::vector<Aov> parseAovs(std::string_view list) {
  std::vector<Aov> result;
  for (std::string_view part : splitAtCommas(list)) {
    const std::string_view name = trimmed(part);
    const AovInfo* aov = findAov(name);
    if (!aov) badUsage("there is no AOV \"{}\"; give a comma-separated list of: {}", name, names());
    if (!contains(result, aov->aov)) result.push_back(aov->aov);
  }
  return result;
}

AovImage makeAovImage(Aov aov, uint32_t width, uint32_t height) {
  AovImage image{aov, width, height, {}, {}};
  const size_t pixels = size_t{width} * height;
  const AovInfo& entry = info(aov);
  if (holdsIntegers(aov)) {
    image.ids.assign(pixels, 0);
  } else {
    image.values.assign(pixels * entry.channels, entry.background);
  }
  return image;
}

}  // namespace latelight::output
