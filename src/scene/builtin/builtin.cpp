// Parses the names and parameters of built-in scenes, and generates them.
#include "scene/builtin/builtin.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/text.h"
#include "scene/builtin/make.h"
#include "scene/ids.h"

namespace latelight::scene {
namespace {

std::string countText(uint64_t n) {
  if (n >= 1'000'000 && n % 1'000'000 == 0) return fmt::format("{}M", n / 1'000'000);
  if (n >= 1'000 && n % 1'000 == 0) return fmt::format("{}k", n / 1'000);
  return fmt::format("{}", n);
}

std::string parameterList(const Builtin& builtin) {
  std::string text;
  for (const BuiltinParameter& p : builtin.parameters)
    text += fmt::format("{}{} ({} to {})", text.empty() ? "" : ", ", p.key, countText(p.least), countText(p.most));
  return text.empty() ? "none" : text;
}

std::string sceneList() {
  std::string text;
  for (const Builtin& builtin : builtins()) text += fmt::format("{}builtin:{}", text.empty() ? "" : ", ", builtin.name);
  return text;
}

const Builtin& findBuiltin(std::string_view name) {
  for (const Builtin& builtin : builtins())
    if (builtin.name == name) return builtin;
  badUsage("There is no built-in scene '{}': there are {}", name, sceneList());
}

void setParameter(const Builtin& builtin, std::string_view setting, std::vector<uint64_t>& values) {
  const size_t equals = setting.find('=');
  const std::string_view key = setting.substr(0, equals);
  const auto found = std::find_if(builtin.parameters.begin(), builtin.parameters.end(),
                                  [&](const BuiltinParameter& p) { return p.key == key; });
  if (equals == std::string_view::npos || found == builtin.parameters.end())
    badUsage("builtin:{} has no parameter '{}': its parameters are {}, written key=value", builtin.name, setting,
             parameterList(builtin));
  const std::optional<uint64_t> value = parseCount(setting.substr(equals + 1));
  if (!value || *value < found->least || *value > found->most)
    badUsage(
        "builtin:{} does not support {}: set {} to a whole number from {} to {} (k and M are thousands and millions)",
        builtin.name, setting, key, countText(found->least), countText(found->most));
  values[static_cast<size_t>(found - builtin.parameters.begin())] = *value;
}

constexpr BuiltinParameter kHallParameters[] = {
    {"triangles", "of all instances together", 50'000, 50'000'000, 300'000},
    {"lights", "point lights", 1, 1'000'000, 100},
    {"seed", "another arrangement", 0, 1'000'000, 1},
    {"glass", "1: glass cases around the exhibits, half of which are of colored glass", 0, 1, 0},
};

constexpr BuiltinParameter kTrianglesParameters[] = {
    {"count", "triangles", 1, 50'000'000, 1'000'000},
    {"size", "tenths of a pixel, of their legs, in a picture 2048 pixels high", 1, 20'480, 15},
};

constexpr Builtin kBuiltins[] = {
    {"hall", "a colonnaded hall with a coffered vault, lit by warm lights", kHallParameters,
     [](std::span<const uint64_t> v, uint32_t textureSlots) {
       return builtin::makeHall({v[0], static_cast<uint32_t>(v[1]), v[2], v[3] != 0, textureSlots});
     }},
    {"spheres",
     "metalness and roughness over a grid of spheres",
     {},
     [](std::span<const uint64_t>, uint32_t) { return builtin::makeSpheres(); }},
    {"boxes",
     "axis-aligned boxes with a closed-form answer",
     {},
     [](std::span<const uint64_t>, uint32_t) { return builtin::makeBoxes(); }},
    {"triangles", "random triangles, to measure rasterization with", kTrianglesParameters,
     [](std::span<const uint64_t> v, uint32_t) {
       return builtin::makeTriangles(v[0], 0.1 * static_cast<double>(v[1]));
     }},
};

// Returns the memory of the scene's meshes, textures and instances.
uint64_t bytesOf(const Scene& scene) {
  uint64_t bytes = scene.instances.size() * sizeof(Instance) + scene.nodes.size() * sizeof(Node);
  for (const Mesh& mesh : scene.meshes) bytes += mesh.bytes();
  for (const Texture& texture : scene.textures) bytes += texture.bytes();
  return bytes;
}

}  // namespace

std::span<const Builtin> builtins() {
  return kBuiltins;
}

std::optional<uint64_t> parseCount(std::string_view text) {
  uint64_t unit = 1;
  if (text.ends_with('k')) unit = 1'000;
  if (text.ends_with('M')) unit = 1'000'000;
  if (unit > 1) text.remove_suffix(1);
  const size_t point = std::min(text.find('.'), text.size());
  const std::string_view whole = text.substr(0, point);
  const std::string_view fraction = text.substr(std::min(point + 1, text.size()));
  const auto parse = [](std::string_view digits) -> std::optional<uint64_t> {
    const auto value = parseNumber<uint64_t>(digits);
    return value && *value < uint64_t{1} << 40 ? value : std::nullopt;
  };
  const std::optional<uint64_t> count = parse(whole);
  if (!count || point == text.size()) return count ? std::optional(*count * unit) : std::nullopt;
  const std::optional<uint64_t> parts = parse(fraction);
  if (!parts || fraction.empty() || fraction.size() > 6) return std::nullopt;
  uint64_t place = unit;
  for (size_t i = 0; i < fraction.size(); ++i) {
    if (place % 10 != 0) return std::nullopt;
    place /= 10;
  }
  return *count * unit + *parts * place;
}

Scene makeBuiltin(const std::string& name, uint32_t textureSlots) {
  std::string_view rest = name;
  const Builtin& builtin = findBuiltin(rest.substr(0, rest.find(',')));
  std::vector<uint64_t> values;
  for (const BuiltinParameter& p : builtin.parameters) values.push_back(p.normal);
  rest.remove_prefix(builtin.name.size());
  while (!rest.empty()) {
    rest.remove_prefix(1);
    const size_t end = std::min(rest.find(','), rest.size());
    setParameter(builtin, rest.substr(0, end), values);
    rest.remove_prefix(end);
  }
  Scene scene = builtin.make(values, textureSlots);
  scene.name = builtin.name;
  scene.source = "builtin:" + name;
  scene.memory.grow(bytesOf(scene), fmt::format("the scene builtin:{}", name));
  identifyMaterials(scene);
  for (const Instance& instance : scene.instances)
    scene.nodes[instance.node].mesh = scene.meshes[instance.mesh].name;  // each node has at most one primitive
  return scene;
}

}  // namespace latelight::scene
