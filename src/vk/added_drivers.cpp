// NVIDIA's container runtime mounts the driver's libraries, but the manifest (nvidia_icd.json) is missing or in a
// folder that no loader searches with some versions and settings (github.com/NVIDIA/nvidia-container-toolkit, issues
// 16, 767 and 1559). Where it is there, it names libGLX_nvidia.so.0, which requires libX11 and libXext: images without
// them get no device, though libEGL_nvidia.so.0 is the same driver and requires neither (issues 191 and 1952).
#include "vk/added_drivers.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <system_error>

#include "base/error.h"
#include "base/files.h"
#include "vk/drivers.h"

namespace latelight::vk {

namespace {

namespace fs = std::filesystem;

constexpr const char* kAdd = "VK_ADD_DRIVER_FILES";
constexpr const char* kDisable = "VK_LOADER_DRIVERS_DISABLE";

std::vector<AddedDriver>& added() {
  static std::vector<AddedDriver> drivers;
  return drivers;
}

bool isSet(const char* name) {
  const char* value = std::getenv(name);
  return value && *value;
}

// Puts `value` in front of the list that the variable holds, unless it is there: child processes inherit the list.
void prepend(const char* name, const std::string& value, char separator) {
  const std::string list = isSet(name) ? std::getenv(name) : "";
  const std::string ends = separator + list + separator;
  if (ends.find(separator + value + separator) != std::string::npos) return;
  setenv(name, list.empty() ? value.c_str() : (value + separator + list).c_str(), 1);
}

// The manifest for NVIDIA's driver, in the cache. Without a cache there is no place that other users cannot write to.
std::optional<fs::path> nvidiaManifest() {
  std::optional<fs::path> cache = cacheFolder();
  return cache ? std::optional(*cache / "nvidia_icd.json") : std::nullopt;
}

bool writeManifest(const fs::path& path, const std::string& library) {
  if (readDriverFile(path).library == library) return true;  // of an earlier process
  const nlohmann::ordered_json manifest{{"file_format_version", "1.0.0"},
                                        {"ICD", {{"library_path", library}, {"api_version", "1.3.0"}}}};
  const std::string text = manifest.dump(2) + "\n";
  try {
    writeFile(path, std::as_bytes(std::span(text)));
  } catch (const Error&) {
    return false;
  }
  return true;
}

void addNvidia() {
  const std::optional<fs::path> own = nvidiaManifest();
  if (!own) return;
  bool listed = false;
  for (const fs::path& file : findDriverFiles().files) {
    if (file == *own || !readDriverFile(file).isNvidia()) continue;
    if (probeDriver(file).error.empty()) return;
    listed = true;
  }
  const NvidiaLibrary last = probeNvidiaLibraries().back();
  if (!last.error.empty() || !writeManifest(*own, last.library)) return;
  prepend(kAdd, own->string(), ':');
  added().push_back({*own, fmt::format("NVIDIA's driver has {}, so Latelight has made one for {}.",
                                       listed ? "no driver file that works" : "no driver file", last.library)});
}

// LATELIGHT_CPU_DRIVER, which the Python package sets to the driver of latelight-cpu, or the archive's driver next to
// the program.
std::optional<fs::path> findCpuDriver() {
  if (isSet("LATELIGHT_CPU_DRIVER")) return std::getenv("LATELIGHT_CPU_DRIVER");
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  fs::path packed = program.parent_path().parent_path() / "lib/cpu/latelight_cpu_icd.json";
  if (error || !fs::exists(packed, error)) return std::nullopt;
  return packed;
}

void addCpuDriver() {
  const std::optional<fs::path> manifest = findCpuDriver();
  if (!manifest || !probeDriver(*manifest).error.empty()) return;
  prepend(kAdd, manifest->string(), ':');
  prepend(kDisable, "lvp_icd*", ',');
  added().push_back({*manifest, "Latelight's own CPU driver replaces that of the system.", true});
}

}  // namespace

void addDrivers() {
  if (isSet("VK_DRIVER_FILES") || isSet("VK_ICD_FILENAMES")) return;
  addNvidia();
  addCpuDriver();
}

const std::vector<AddedDriver>& addedDrivers() {
  return added();
}

}  // namespace latelight::vk
