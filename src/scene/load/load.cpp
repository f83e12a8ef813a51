#include "scene/load/load.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "base/error.h"
#include "scene/builtin/builtin.h"
#include "scene/gltf/load.h"
#include "scene/ids.h"

namespace latelight::scene {
namespace {

constexpr std::string_view kBuiltin = "builtin:";

bool endsWith(std::string_view text, std::string_view ending) {
  if (text.size() < ending.size()) return false;
  text.remove_prefix(text.size() - ending.size());
  for (size_t i = 0; i < ending.size(); ++i) {
    const char c = text[i];
    if ((c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c) != ending[i]) return false;
  }
  return true;
}

// Recognizes .glb files by "glTF", and .gltf files by a JSON object, optionally after a byte-order mark.
bool looksLikeGltf(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return true;  // a pipe, whose peeked bytes would be lost
  std::array<char, 64> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  std::string_view text(head.data(), static_cast<size_t>(file.gcount()));
  if (text.starts_with("glTF")) return true;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  const size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && text[first] == '{';
}

Scene loadBuiltin(const std::string& source, const LoadOptions& options) {
  if (!options.variant.empty()) badUsage("{} has no material variants: omit the variant '{}'", source, options.variant);
  Scene scene = makeBuiltin(source.substr(kBuiltin.size()), options.textureSlots);
  scene.source = source;
  return scene;
}

Scene loadFile(const std::string& source, const LoadOptions& options) {
  const std::filesystem::path path(source);
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status))
    badInput("The scene file {} does not exist: give a .gltf or .glb file, or a built-in scene such as builtin:hall",
             source);
  if (std::filesystem::is_directory(status))
    badInput("{} is a folder: give a .gltf or .glb file, or a built-in scene such as builtin:hall", source);
  if (!endsWith(source, ".gltf") && !endsWith(source, ".glb") && !looksLikeGltf(path))
    badInput("{} is not a glTF file: give a .gltf or .glb file, or a built-in scene such as builtin:hall", source);
  return loadGltf(path, options);
}

}  // namespace

Scene load(const std::string& source, const LoadOptions& options) {
  checkGrouping(options.ids);
  Scene scene = source.starts_with(kBuiltin) ? loadBuiltin(source, options) : loadFile(source, options);
  groupIds(scene, options.ids);
  return scene;
}

}  // namespace latelight::scene
