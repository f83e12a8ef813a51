#include "output/files.h"

#include <algorithm>
#include <climits>
#include <limits>
#include <system_error>

#include "base/error.h"
#include "base/files.h"
#include "base/lowercase.h"
#include "output/exr.h"
#include "output/npy.h"
#include "output/png.h"

namespace latelight::output {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kPlaceholders = "{aov}, {frame}, {camera}, {scene}";
constexpr std::string_view kStandardOutput = "-";

// Returns nothing if the extension is unknown.
std::optional<Format> knownFormatOf(std::string_view pattern) {
  if (pattern == kStandardOutput) return Format::Png;
  const std::string ending = lowercaseExtension(pattern);
  if (ending == ".png") return Format::Png;
  if (ending == ".exr") return Format::Exr;
  if (ending == ".npy") return Format::Npy;
  return std::nullopt;
}

bool hasPlaceholder(std::string_view pattern, std::string_view name) {
  return pattern.find(fmt::format("{{{}}}", name)) != std::string_view::npos;
}

// Makes a name safe as part of a file name: no folders, no control characters, not hidden.
std::string fileSafe(std::string name, std::string_view fallback) {
  for (char& c : name) {
    if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '_';
  }
  if (!name.empty() && name[0] == '.') name[0] = '_';
  return name.empty() ? std::string(fallback) : shortFileName(std::move(name));
}

// Replaces the pattern's placeholders with `valueOf(name)`, which throws for an unknown name.
template <typename ValueOf>
std::string fillIn(std::string_view pattern, ValueOf&& valueOf) {
  std::string result;
  for (size_t at = 0; at < pattern.size();) {
    const size_t brace = std::min(pattern.find_first_of("{}", at), pattern.size());
    result += pattern.substr(at, brace - at);
    if (brace == pattern.size()) break;
    const size_t end = pattern[brace] == '{' ? pattern.find('}', brace) : std::string_view::npos;
    if (end == std::string_view::npos) {
      badUsage("the output \"{}\" has an unmatched brace; braces may contain only {}", pattern, kPlaceholders);
    }
    result += valueOf(pattern.substr(brace + 1, end - brace - 1));
    at = end + 1;
  }
  return result;
}

// Inserts {aov} into the pattern if the AOVs need several files.
std::string patternFor(const OutputRequest& request, Aov aov) {
  if (hasPlaceholder(request.pattern, "aov") || formatOf(request.pattern) == Format::Exr) return request.pattern;
  if (request.aovs.size() == 1 || aov == Aov::Color) return request.pattern;
  const size_t ending = request.pattern.rfind('.');
  return request.pattern.substr(0, ending) + ".{aov}" + request.pattern.substr(ending);
}

bool wantsSideFile(const OutputRequest& request) {
  if (request.pattern == kStandardOutput) return false;
  const auto isData = [](Aov aov) { return aov != Aov::Color; };
  return request.sideFile.value_or(std::any_of(request.aovs.begin(), request.aovs.end(), isData));
}

// Returns true if all outputs share one file.
bool isTogether(const OutputRequest& request) {
  return formatOf(request.pattern) == Format::Exr && !hasPlaceholder(request.pattern, "aov");
}

void checkPng(std::span<const Aov> aovs) {
  for (const Aov aov : aovs) {
    if (info(aov).png != PngCoding::None) continue;
    badUsage("a PNG file cannot store {}, whose range is unknown in advance; write to .exr or .npy", info(aov).name);
  }
}

// Returns the folder that must exist before rendering: the parent of the first folder with a placeholder; for a
// sequence, its deepest existing ancestor.
fs::path standingFolder(const fs::path& pattern) {
  fs::path folder;
  for (const fs::path& part : pattern.parent_path()) {
    if (part.string().find('{') != std::string::npos) break;
    folder /= part;
  }
  std::error_code ignored;
  if (hasPlaceholder(pattern.string(), "frame"))
    while (!folder.empty() && folder != folder.root_path() && !fs::exists(folder, ignored))
      folder = folder.parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

const AovImage& imageOf(const FrameOutput& frame, Aov aov) {
  for (const AovImage& image : frame.aovs)
    if (image.aov == aov) return image;
  fail(ExitCode::Internal, "the frame has no {}", info(aov).name);
}

// `add` receives a path and the bytes of the file.
template <typename Add>
void addPng(const Add& add, const fs::path& path, const FrameOutput& frame, Aov aov) {
  if (aov == Aov::Color && !frame.display.empty())
    add(path, frame.displayPng());
  else
    add(path, encodePng(imageOf(frame, aov)));
}

std::vector<std::byte> encode(Format format, std::span<const Aov> aovs, const FrameOutput& frame,
                              const Metadata& metadata) {
  if (format == Format::Npy) return encodeNpy(imageOf(frame, aovs.front()));
  std::vector<const AovImage*> images;
  for (const Aov aov : aovs) images.push_back(&imageOf(frame, aov));
  return encodeExr(images, metadata);
}

}  // namespace

std::span<const std::byte> FrameOutput::displayPng() const {
  if (cachedPng.empty())
    cachedPng = encodePng(width, height, 4, 8, reinterpret_cast<const std::byte*>(display.data()), PngLight::Srgb);
  return cachedPng;
}

void forgetMotion(FrameOutput& frame, bool previous, bool next) {
  for (AovImage& image : frame.aovs) {
    if (!dependsOnNeighbors(image.aov)) continue;
    for (size_t i = 0; i < image.values.size(); ++i)
      if (image.aov == Aov::Motion && i % 4 < 2 ? previous : next)
        image.values[i] = std::numeric_limits<float>::quiet_NaN();
  }
}

Format formatOf(std::string_view pattern) {
  if (const std::optional<Format> format = knownFormatOf(pattern)) return *format;
  badUsage("the output \"{}\" has an unknown file extension; use .png, .exr or .npy", pattern);
}

bool isPngName(std::string_view pattern) {
  return knownFormatOf(pattern) == Format::Png;
}

bool usesDisplay(const OutputRequest& request) {
  const bool color = contains(request.aovs, Aov::Color);
  return color && formatOf(request.pattern) == Format::Png;
}

bool writesMetadata(const OutputRequest& request) {
  return wantsSideFile(request) || formatOf(request.pattern) == Format::Exr;
}

namespace {

fs::path fill(std::string_view pattern, std::string_view aov, std::string_view frame, const Metadata& metadata) {
  const fs::path path = fillIn(pattern, [&](std::string_view name) -> std::string {
    if (name == "aov") return std::string(aov);
    if (name == "frame") return std::string(frame);
    if (name == "camera") return fileSafe(metadata.camera.name, "camera");
    if (name == "scene") return fileSafe(metadata.scene, "scene");
    badUsage("the output \"{}\" has \"{{{}}}\"; braces hold one of {}", pattern, name, kPlaceholders);
  });
  for (const fs::path& part : path)
    if (part.native().size() > NAME_MAX)
      badUsage("the output \"{}\" makes the file name \"{}\" of {} bytes, longer than the {} that file systems allow",
               pattern, part.string(), part.native().size(), NAME_MAX);
  return path;
}

// An EXR file of a sequence lists only the ids that it shows; the full list would dominate a small file.
Metadata exrMetadata(const OutputRequest& request, std::span<const AovImage> images, const Metadata& metadata) {
  Metadata own = metadata;
  if (request.inSequence && own.ids) own.ids = std::make_shared<IdManifest>(shownIn(*own.ids, images));
  return own;
}

}  // namespace

fs::path fillPattern(std::string_view pattern, std::string_view aov, const Metadata& metadata) {
  return fill(pattern, aov, fmt::format("{:0{}}", metadata.frame, metadata.frameDigits), metadata);
}

void makeFilledFolders(const fs::path& pattern, const fs::path& path) {
  std::error_code ignored;  // writing reports the error
  if (pattern.parent_path().string().find('{') != std::string::npos || hasPlaceholder(pattern.string(), "frame"))
    fs::create_directories(path.parent_path(), ignored);
}

void checkPattern(std::string_view pattern) {
  fillPattern(pattern, "", {});
  const fs::path path(pattern), folder = standingFolder(path);
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    badUsage("can't write '{}': {}", pattern,
             fs::exists(folder, ignored)
                 ? fmt::format("'{}' is not a folder; choose another", folder.string())
                 : fmt::format("the folder '{}' does not exist; create it first, or choose another", folder.string()));
  checkWritable(path.has_parent_path() ? folder / path.filename() : path);
}

void checkOutput(const OutputRequest& request) {
  const Format format = formatOf(request.pattern);
  if (request.aovs.empty()) badUsage("no AOV is requested; name at least one");
  if (request.pattern == kStandardOutput && request.aovs.size() > 1)
    badUsage("-o - writes one PNG file, but --aov names {} outputs; name one of them, or write to a .exr file",
             request.aovs.size());
  if (format == Format::Png) checkPng(request.aovs);
  if (request.pattern != kStandardOutput) checkPattern(request.pattern);
}

std::vector<fs::path> outputPaths(const OutputRequest& request, const Metadata& metadata) {
  if (request.pattern == kStandardOutput) return {};
  std::vector<fs::path> paths;
  for (const Aov aov : std::span(request.aovs).first(isTogether(request) ? 1 : request.aovs.size()))
    paths.push_back(fillPattern(patternFor(request, aov), info(aov).name, metadata));
  if (wantsSideFile(request))
    paths.push_back(fillPattern(request.pattern, "meta", metadata).replace_extension(".json"));
  return paths;
}

std::optional<fs::path> idManifestPath(const OutputRequest& request, const Metadata& metadata) {
  if (!request.inSequence || request.pattern.empty() || !wantsSideFile(request) ||
      std::ranges::none_of(request.aovs, holdsIds))
    return std::nullopt;
  return fill(request.pattern, "meta", "ids", metadata).replace_extension(".json");
}

void writeIdManifest(const OutputRequest& request, const Metadata& metadata) {
  const std::optional<fs::path> path = idManifestPath(request, metadata);
  if (!path || !metadata.ids) return;
  const std::string text = idManifestText(*metadata.ids);
  makeFilledFolders(request.pattern, *path);
  writeFile(*path, std::as_bytes(std::span(text)));
}

std::vector<fs::path> writeOutput(const OutputRequest& request, const FrameOutput& frame, const Metadata& metadata) {
  const Format format = formatOf(request.pattern);
  if (request.pattern == kStandardOutput) {
    addPng(writeFile, kStandardOutput, frame, request.aovs.front());
    return {};
  }
  const std::vector<fs::path> paths = outputPaths(request, metadata);
  const bool together = isTogether(request);
  FileGroup files;
  for (size_t i = 0; i < (together ? 1 : request.aovs.size()); ++i) {
    makeFilledFolders(request.pattern, paths[i]);
    const std::span<const Aov> all(request.aovs);
    if (format == Format::Png)
      addPng([&](const fs::path& path, std::span<const std::byte> bytes) { files.add(path, bytes); }, paths[i], frame,
             all[i]);
    else
      files.add(paths[i], encode(format, together ? all : all.subspan(i, 1), frame,
                                 format == Format::Exr ? exrMetadata(request, frame.aovs, metadata) : metadata));
  }
  if (wantsSideFile(request)) {
    const fs::path& side = paths.back();
    std::vector<std::string> names;  // one per AOV, relative to the side file
    for (size_t i = 0; i < request.aovs.size(); ++i)
      names.push_back(paths[together ? 0 : i].lexically_proximate(side.parent_path()).generic_string());
    Metadata described = metadata;
    if (const auto ids = idManifestPath(request, metadata))
      described.idManifest = ids->lexically_proximate(side.parent_path()).generic_string();
    const std::string text = sideFile(described, frame.width, frame.height, request.aovs, names);
    makeFilledFolders(request.pattern, side);
    files.add(side, std::as_bytes(std::span(text)));
  }
  files.commit();
  return paths;
}

void writePicture(const fs::path& path, const Picture& picture) {
  writeFile(path, encodePng(picture));
}

}  // namespace latelight::output
