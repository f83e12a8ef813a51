#include "vk/drivers.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <volk.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string_view>
#include <system_error>

#include "base/json_tree.h"

namespace latelight::vk {

namespace fs = std::filesystem;

namespace {

std::string variable(const char* name, const std::string& otherwise = "") {
  const char* value = std::getenv(name);
  return value && *value ? value : otherwise;
}

std::vector<fs::path> splitPaths(std::string_view list) {
  std::vector<fs::path> paths;
  while (!list.empty()) {
    const size_t end = std::min(list.find(':'), list.size());
    if (end > 0) paths.emplace_back(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return paths;
}

std::vector<fs::path> driverFolders() {
  const std::string home = variable("HOME");
  std::vector<fs::path> bases;
  const auto add = [&](const std::string& list) {
    for (const fs::path& path : splitPaths(list)) bases.push_back(path);
  };
  add(variable("XDG_CONFIG_HOME", home.empty() ? "" : home + "/.config"));
  add(variable("XDG_CONFIG_DIRS", "/etc/xdg"));
  add("/etc");
  add(variable("XDG_DATA_HOME", home.empty() ? "" : home + "/.local/share"));
  add(variable("XDG_DATA_DIRS", "/usr/local/share:/usr/share"));
  std::vector<fs::path> folders;
  for (const fs::path& base : bases) {
    const fs::path folder = base / "vulkan/icd.d";
    if (std::find(folders.begin(), folders.end(), folder) == folders.end()) folders.push_back(folder);
  }
  return folders;
}

std::vector<fs::path> jsonFilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->path().extension() == ".json") files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  return files;
}

// The files that an environment variable lists; entries are files or folders.
std::vector<fs::path> filesOf(const std::string& list) {
  std::vector<fs::path> files;
  for (const fs::path& path : splitPaths(list)) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    for (fs::path& file : jsonFilesIn(path)) files.push_back(std::move(file));
  }
  return files;
}

}  // namespace

DriverFiles findDriverFiles() {
  DriverFiles found;
  for (const char* name : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) {
    const std::string list = variable(name);
    if (list.empty()) continue;
    return {fmt::format("the variable {} ({})", name, list), filesOf(list)};
  }
  found.files = filesOf(variable("VK_ADD_DRIVER_FILES"));
  std::vector<std::string> names;
  for (const fs::path& folder : driverFolders()) {
    names.push_back(folder.string());
    for (fs::path& file : jsonFilesIn(folder)) found.files.push_back(std::move(file));
  }
  found.where = fmt::format("{}", fmt::join(names, ", "));
  return found;
}

DriverProbe readDriverFile(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return {"", "is not there"};
  std::ifstream stream(file);
  if (!stream) return {"", "cannot be read"};
  const JsonTree tree = nlohmann::json::parse(stream, nullptr, false);
  const nlohmann::json& json = *tree;
  if (json.is_discarded()) return {"", "is not JSON"};
  const auto icd = json.is_object() ? json.find("ICD") : json.end();
  if (!json.is_object() || icd == json.end() || !icd->is_object() || !icd->contains("library_path") ||
      !(*icd)["library_path"].is_string())
    return {"", "is not a driver file: it has no ICD.library_path"};
  return {(*icd)["library_path"].get<std::string>(), ""};
}

std::string probeDriverLibrary(const std::string& library) {
  void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) return fmt::format("does not load ({})", dlerror());
  // The library stays open: the loader will open it again, and some drivers crash when they are unloaded.
  using Entry = PFN_vkVoidFunction (*)(VkInstance, const char*);
  auto entry = reinterpret_cast<Entry>(dlsym(handle, "vk_icdGetInstanceProcAddr"));
  if (!entry) entry = reinterpret_cast<Entry>(dlsym(handle, "vkGetInstanceProcAddr"));
  if (!entry) return "is not a Vulkan driver";
  // NVIDIA's driver loads, but has no functions, where libraries that it opens later are missing.
  if (!entry(VK_NULL_HANDLE, "vkCreateInstance")) return "is a Vulkan driver that cannot create an instance";
  return "";
}

std::vector<NvidiaLibrary> probeNvidiaLibraries() {
  std::vector<NvidiaLibrary> libraries;
  // The last two folders are where NVIDIA's container tools and some clusters mount the driver.
  for (const char* folder : {"", "/usr/local/nvidia/lib64/", "/usr/local/nvidia/lib/"})
    for (const char* name : {"libGLX_nvidia.so.0", "libEGL_nvidia.so.0"}) {
      const std::string library = std::string(folder) + name;
      const std::string error = probeDriverLibrary(library);
      // dlopen's message begins with the name of the library that is missing, which may be one that this one needs.
      libraries.push_back({library, error, error.starts_with("does not load (" + library + ": cannot open")});
      if (error.empty()) return libraries;
    }
  return libraries;
}

DriverProbe probeDriver(const fs::path& file) {
  DriverProbe probe = readDriverFile(file);
  if (!probe.error.empty()) return probe;
  // A name with a slash is a path, relative to the file's folder if not absolute. The dynamic linker searches for a
  // name without a slash.
  const bool isPath = probe.library.find('/') != std::string::npos;
  const std::string library = isPath ? (file.parent_path() / probe.library).string() : probe.library;
  if (const std::string error = probeDriverLibrary(library); !error.empty())
    probe.error = fmt::format("names the library {}, which {}", probe.library, error);
  return probe;
}

}  // namespace latelight::vk
