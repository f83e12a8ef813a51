#include "output/aov.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <optional>

#include "base/error.h"
#include "base/text.h"

namespace latelight::output {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();

constexpr std::array<AovInfo, kAovCount> kAovs{{
    {Aov::Color,
     "color",
     4,
     {"R", "G", "B", "A"},
     ExrType::Half,
     PngCoding::Display,
     0,
     "1",
     "Linear Rec.709 light after exposure, before the tonemap; alpha premultiplied"},
    {Aov::Depth,
     "depth",
     1,
     {"Z"},
     ExrType::Float,
     PngCoding::Millimetre,
     kInf,
     "m",
     "Distance from the camera's plane, along its view axis"},
    {Aov::Distance,
     "distance",
     1,
     {"distance"},
     ExrType::Float,
     PngCoding::Millimetre,
     kInf,
     "m",
     "Distance from the camera's centre, along the pixel's ray"},
    {Aov::Normal,
     "normal",
     3,
     {"N.X", "N.Y", "N.Z"},
     ExrType::Float,
     PngCoding::Signed,
     0,
     "1",
     "Unit normal that is shaded with, normal map included"},
    {Aov::GeoNormal,
     "geonormal",
     3,
     {"NG.X", "NG.Y", "NG.Z"},
     ExrType::Float,
     PngCoding::Signed,
     0,
     "1",
     "Unit normal of the triangle"},
    {Aov::Position,
     "position",
     3,
     {"P.X", "P.Y", "P.Z"},
     ExrType::Float,
     PngCoding::None,
     0,
     "m",
     "Position of the surface"},
    {Aov::Albedo,
     "albedo",
     3,
     {"albedo.R", "albedo.G", "albedo.B"},
     ExrType::Half,
     PngCoding::Srgb,
     0,
     "1",
     "Base colour, linear Rec.709"},
    {Aov::Metallic, "metallic", 1, {"metallic"}, ExrType::Half, PngCoding::Unit, 0, "1", "Metalness"},
    {Aov::Roughness,
     "roughness",
     1,
     {"roughness"},
     ExrType::Half,
     PngCoding::Unit,
     0,
     "1",
     "Perceptual roughness, the square root of GGX's alpha"},
    {Aov::Emissive,
     "emissive",
     3,
     {"emissive.R", "emissive.G", "emissive.B"},
     ExrType::Half,
     PngCoding::Srgb,
     0,
     "cd/m2",
     "Emitted light before exposure, linear Rec.709"},
    {Aov::Ao,
     "ao",
     1,
     {"ao"},
     ExrType::Half,
     PngCoding::Unit,
     0,
     "1",
     "Share of the surroundings' light that arrives, by the material's occlusion texture"},
    {Aov::Id,
     "id",
     1,
     {"id"},
     ExrType::Uint,
     PngCoding::IdBytes,
     0,
     "1",
     "Stable id of the node, or of the group it is in, as in the manifest; 0 is background"},
    {Aov::Part,
     "part",
     1,
     {"part"},
     ExrType::Uint,
     PngCoding::IdBytes,
     0,
     "1",
     "Stable id of the node's primitive, as in the manifest; 0 is background"},
    {Aov::Material,
     "material",
     1,
     {"material"},
     ExrType::Uint,
     PngCoding::IdBytes,
     0,
     "1",
     "Stable id of the material, as in the manifest; 0 is background"},
    {Aov::Uv,
     "uv",
     2,
     {"uv.U", "uv.V"},
     ExrType::Float,
     PngCoding::Fraction,
     0,
     "1",
     "First texture coordinates, as in the file"},
    {Aov::LightsTested,
     "lights-tested",
     1,
     {"lights.tested"},
     ExrType::Float,
     PngCoding::Count,
     0,
     "1",
     "Lights that the lighting technique went through for the pixel"},
    {Aov::LightsUsed,
     "lights-used",
     1,
     {"lights.used"},
     ExrType::Float,
     PngCoding::Count,
     0,
     "1",
     "Lights of those that sent light from the pixel's surface to the eye"},
    {Aov::Samples,
     "samples",
     1,
     {"samples"},
     ExrType::Float,
     PngCoding::Count,
     0,
     "1",
     "Times the pixel is shaded: 1, or with --aa msaa4 once for each surface that its samples show"},
    {Aov::Motion,
     "motion",
     4,
     {"motion.X", "motion.Y", "motion.Z", "motion.W"},
     ExrType::Float,
     PngCoding::None,
     0,
     "px",
     "X Y: where the surface was a frame before, less where it is; Z W: where it will be a frame after, less that"},
}};

std::optional<Aov> findAov(std::string_view name) {
  for (const AovInfo& aov : kAovs)
    if (aov.name == name) return aov.aov;
  return std::nullopt;
}

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

bool contains(std::span<const Aov> aovs, Aov aov) {
  return std::find(aovs.begin(), aovs.end(), aov) != aovs.end();
}

bool holdsIds(Aov aov) {
  return info(aov).exr == ExrType::Uint;
}

std::vector<Aov> parseAovs(std::string_view list) {
  std::vector<Aov> result;
  for (std::string_view part : splitAtCommas(list)) {
    const std::string_view name = trimmed(part);
    const std::optional<Aov> aov = findAov(name);
    if (!aov) badUsage("there is no AOV \"{}\"; give a comma-separated list of: {}", name, names());
    if (!contains(result, *aov)) result.push_back(*aov);
  }
  return result;
}

AovImage makeAovImage(Aov aov, uint32_t width, uint32_t height) {
  AovImage image{aov, width, height, {}, {}};
  const size_t pixels = size_t{width} * height;
  const AovInfo& entry = info(aov);
  if (holdsIds(aov)) {
    image.ids.assign(pixels, 0);
  } else {
    image.values.assign(pixels * entry.channels, entry.background);
  }
  return image;
}

}  // namespace latelight::output
