#include "vk/shaders.h"

#include <cstring>
#include <deque>
#include <map>
#include <mutex>
#include <unordered_map>

#include <zstd.h>

#include "base/error.h"
#include "base/files.h"
#include "base/fork.h"
#include "vk/spirv.h"

namespace latelight::vk {

// The shaders, embedded by an assembly file as Zstandard frames from `symbol` to `symbolEnd`.
#define SHADER(symbol, name)           \
  extern "C" const std::byte symbol[]; \
  extern "C" const std::byte symbol##End[];
#include "shaders.inc"
#undef SHADER

namespace {

using Words = std::vector<uint32_t>;

struct EmbeddedShader {
  const char* name;
  const std::byte* begin;
  const std::byte* end;
};

constexpr EmbeddedShader kShaders[] = {
#define SHADER(symbol, name) {name, symbol, symbol##End},
#include "shaders.inc"
#undef SHADER
    {nullptr, nullptr, nullptr},
};

Words decompress(const EmbeddedShader& shader) {
  const size_t bytes = shader.end - shader.begin;
  Words words(ZSTD_getFrameContentSize(shader.begin, bytes) / sizeof(uint32_t));
  const size_t size = words.size() * sizeof(uint32_t);
  if (ZSTD_decompress(words.data(), size, shader.begin, bytes) != size)
    fail(ExitCode::Internal, "The embedded shader {} is damaged.", shader.name);
  return words;
}

// The embedded shaders, each decompressed when it is first used. Passes look shaders up in every frame.
class EmbeddedShaders {
 public:
  EmbeddedShaders() {
    for (const EmbeddedShader& shader : kShaders)
      if (shader.name) shaders_.try_emplace(shader.name, Entry{shader, {}});
  }
  bool has(std::string_view name) const { return shaders_.contains(name); }
  // Returns an empty span if there is no such shader.
  std::span<const uint32_t> find(std::string_view name) {
    const auto found = shaders_.find(name);
    if (found == shaders_.end()) return {};
    const std::scoped_lock lock(mutex_);
    Entry& entry = found->second;
    if (entry.words.empty()) entry.words = decompress(entry.compressed);
    return entry.words;
  }

 private:
  struct Entry {
    EmbeddedShader compressed;
    Words words;
  };
  std::unordered_map<std::string_view, Entry> shaders_;
  ForkSafeMutex mutex_;  // for Entry::words
};

EmbeddedShaders& embeddedShaders() {
  static EmbeddedShaders all;
  return all;
}

// --- shaders of a folder --------------------------------------------------------------------------------------------

// Earlier versions of a file are kept, because pipelines may still be created from them.
struct FileVersions {
  std::filesystem::file_time_type time{};
  std::deque<Words> words;
};
struct Folder {
  ForkSafeMutex mutex;
  std::filesystem::path path;
  std::map<std::string, FileVersions, std::less<>> read;
};
Folder& folder() {
  static Folder one;
  return one;
}

Words readWords(const std::filesystem::path& file) {
  const std::vector<std::byte> bytes = readFile(file);
  Words words(bytes.size() / sizeof(uint32_t));
  std::memcpy(words.data(), bytes.data(), words.size() * sizeof(uint32_t));
  if (bytes.size() % sizeof(uint32_t) != 0 || words.empty() || words[0] != spv::MagicNumber)
    badInput("{} is not SPIR-V", file.string());
  return words;
}

// Returns an empty span if the folder has no shader of that name.
std::span<const uint32_t> shaderOfFolder(std::string_view name) {
  Folder& f = folder();
  const std::scoped_lock lock(f.mutex);
  if (f.path.empty()) return {};
  const std::filesystem::path file = f.path / (std::string(name) + ".spv");
  std::error_code error;
  const auto time = std::filesystem::last_write_time(file, error);
  if (error) return {};
  FileVersions& versions = f.read[std::string(name)];
  if (versions.words.empty() || versions.time != time) {
    versions.words.push_back(readWords(file));
    versions.time = time;
  }
  return versions.words.back();
}

// Returns the files of a folder that replace shaders of the program.
std::vector<std::filesystem::path> filesIn(const std::filesystem::path& path) {
  std::vector<std::filesystem::path> files;
  for (const std::string_view name : shaderNames())
    if (const auto file = path / (std::string(name) + ".spv"); isThere(file)) files.push_back(file);
  return files;
}

}  // namespace

std::string_view ShaderKey::hitName() const {
  constexpr std::string_view kNames[] = {"", "masked", "blended", "overdraw", "lens", "lens-blended"};
  return kNames[static_cast<size_t>(hit)];
}

std::string ShaderKey::name() const {
  std::string name = file;
  if (!layout.empty()) name += "@" + layout;
  if (samples == Samples::Multisampled) name += "+msaa";
  if (samples == Samples::SampleLayers) name += "+sample-layers";
  if (coated) name += "+coated";
  if (hit != Hit::Opaque) name.append("+").append(hitName());
  if (indexed) name += "+indexed";
  return name;
}

std::span<const uint32_t> shaderCode(const ShaderKey& shader) {
  return shaderCodeOf(shader.name());
}

bool hasShader(const ShaderKey& shader) {
  return embeddedShaders().has(shader.name());
}

std::span<const uint32_t> shaderCodeOf(std::string_view name) {
  const std::span<const uint32_t> embedded = embeddedShaders().find(name);
  if (embedded.empty())
    fail(ExitCode::Internal,
         "No shader called {} is embedded: check the first line of {}, which declares its variants.", name,
         name.substr(0, name.find_first_of("@+")));
  const std::span<const uint32_t> own = shaderOfFolder(name);
  return own.empty() ? embedded : own;
}

std::vector<std::string_view> shaderNames() {
  std::vector<std::string_view> names;
  for (const EmbeddedShader& shader : kShaders)
    if (shader.name) names.push_back(shader.name);
  return names;
}

void useShadersOf(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!path.empty() && !std::filesystem::is_directory(path, ignored))
    badInput("There is no folder {} of shaders", path.string());
  if (!path.empty() && filesIn(path).empty())
    badInput("The folder {} has none of the program's shaders, such as {}.spv: give the one that the build writes",
             path.string(), shaderNames().front());
  Folder& f = folder();
  const std::scoped_lock lock(f.mutex);
  f.path = path;
}

std::vector<std::filesystem::path> shaderFiles() {
  Folder& f = folder();
  const std::scoped_lock lock(f.mutex);
  return f.path.empty() ? std::vector<std::filesystem::path>() : filesIn(f.path);
}

}  // namespace latelight::vk
