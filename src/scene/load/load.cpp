#include "scene/load/load.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/lowercase.h"
#include "scene/builtin/builtin.h"
#include "scene/gltf/load.h"
#include "scene/ids.h"
#include "scene/mesh_files/load.h"

namespace latelight::scene {
namespace {

constexpr std::string_view kBuiltin = "builtin:";

enum class Format { Gltf, Obj, Ply, Stl, Unknown };

constexpr std::pair<std::string_view, Format> kExtensions[] = {{".gltf", Format::Gltf},
                                                               {".glb", Format::Gltf},
                                                               {".obj", Format::Obj},
                                                               {".ply", Format::Ply},
                                                               {".stl", Format::Stl}};

// Returns true if the first line that is not empty or a comment begins with a statement of OBJ.
bool looksLikeObj(std::string_view text) {
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
    if (word.empty() || word.starts_with('#')) continue;
    constexpr std::string_view kStatements[] = {"mtllib", "o", "g", "v", "vn", "vt", "s", "usemtl"};
    return std::ranges::find(kStatements, word) != std::end(kStatements);
  }
  return false;
}

// Recognizes files without a usual extension: .glb by "glTF", .gltf by a JSON object, optionally after a byte-order
// mark, the others by their first words. Binary STL has no mark, but its size follows from its count of facets.
Format formatOfContents(const std::filesystem::path& path) {
  std::error_code ignored;
  // The peeked bytes of a pipe would be lost.
  if (!std::filesystem::is_regular_file(path, ignored)) return Format::Gltf;
  std::array<char, 4096> head{};
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), head.size());
  std::string_view text(head.data(), static_cast<size_t>(file.gcount()));
  if (text.starts_with("glTF")) return Format::Gltf;
  if (text.starts_with("ply\n") || text.starts_with("ply\r")) return Format::Ply;
  uint64_t facets = 0;
  for (size_t i = 0; i < 4 && text.size() >= 84; ++i) facets |= uint64_t{static_cast<uint8_t>(text[80 + i])} << (8 * i);
  if (text.size() >= 84 && std::filesystem::file_size(path, ignored) == 84 + 50 * facets) return Format::Stl;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '{') return Format::Gltf;
  if (text.starts_with("solid ") && text.find("facet") != std::string_view::npos) return Format::Stl;
  return looksLikeObj(text) ? Format::Obj : Format::Unknown;
}

Format formatOf(const std::string& source) {
  const std::string ending = lowercaseExtension(source);
  for (const auto& [extension, format] : kExtensions)
    if (ending == extension) return format;
  return formatOfContents(source);
}

// For scenes that define their unit and axes.
void rejectFrame(const std::string& source, const LoadOptions& options) {
  if (!options.unit.empty() || !options.upAxis.empty() || options.pointRadius)
    badUsage(
        "{} defines its unit and axes: omit --unit, --up-axis and --point-radius, which are for .obj, .ply and .stl",
        source);
}

Scene loadBuiltin(const std::string& source, const LoadOptions& options) {
  if (!options.variant.empty()) badUsage("{} has no material variants: omit the variant '{}'", source, options.variant);
  rejectFrame(source, options);
  Scene scene = makeBuiltin(source.substr(kBuiltin.size()), options.textureSlots);
  scene.source = source;
  return scene;
}

// Names the function of the Python package that converts a file of a format that is not read here.
void refuseConvertible(const std::string& source) {
  constexpr std::pair<std::string_view, std::string_view> kConverters[] = {{".urdf", "from_urdf"},
                                                                           {".usd", "from_usd"},
                                                                           {".usda", "from_usd"},
                                                                           {".usdc", "from_usd"},
                                                                           {".usdz", "from_usd"}};
  const std::string ending = lowercaseExtension(source);
  for (const auto& [extension, function] : kConverters)
    if (ending == extension) badInput("{} is read by the Python package only: use latelight.{}()", source, function);
}

Scene loadFile(const std::string& source, const LoadOptions& options, const FileObserver& observer) {
  const std::filesystem::path path(source);
  if (observer) observer(path);
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  constexpr std::string_view kAdvice =
      "give a .gltf, .glb, .obj, .ply or .stl file, or a built-in scene such as builtin:hall";
  if (!std::filesystem::exists(status)) badInput("The scene file {} does not exist: {}", source, kAdvice);
  if (std::filesystem::is_directory(status)) badInput("{} is a folder: {}", source, kAdvice);
  refuseConvertible(source);
  const Format format = formatOf(source);
  if (format == Format::Unknown) badInput("{} is not a scene file: {}", source, kAdvice);
  if (format == Format::Obj) return loadMeshFile(path, MeshFormat::Obj, options, observer);
  if (format == Format::Ply) return loadMeshFile(path, MeshFormat::Ply, options, observer);
  if (format == Format::Stl) return loadMeshFile(path, MeshFormat::Stl, options, observer);
  rejectFrame(source, options);
  return loadGltf(path, options, observer);
}

}  // namespace

Scene load(const std::string& source, const LoadOptions& options, const FileObserver& observer) {
  checkGrouping(options.ids);
  Scene scene = source.starts_with(kBuiltin) ? loadBuiltin(source, options) : loadFile(source, options, observer);
  groupIds(scene, options.ids);
  return scene;
}

void checkFrame(const std::string& source, const LoadOptions& options) {
  std::error_code ignored;
  const bool isBuiltin = source.starts_with(kBuiltin);
  if (isBuiltin || (std::filesystem::is_regular_file(source, ignored) && formatOf(source) == Format::Gltf))
    rejectFrame(source, options);
}

bool definesFrame(const std::string& source) {
  if (source.starts_with(kBuiltin)) return true;
  const Format format = formatOf(source);
  return format == Format::Gltf || format == Format::Unknown;
}

}  // namespace latelight::scene
