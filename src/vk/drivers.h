// Finds and tests the driver files (ICD manifests) that the Vulkan loader reads, without the loader. Linux only. The
// loader's LoaderDriverInterface.md documents the locations and their order.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace latelight::vk {

struct DriverFiles {
  std::string where;                         // for users: the variable or the folders that were searched
  std::vector<std::filesystem::path> files;  // in the loader's order; a variable may name files that do not exist
};
DriverFiles findDriverFiles();

struct DriverProbe {
  std::string library;  // as named in the file; empty if the file cannot be read
  std::string error;    // the end of a sentence; empty: the driver loads
  bool isNvidia() const { return library.find("nvidia") != std::string::npos; }
};
// Reads the file, without loading its library.
DriverProbe readDriverFile(const std::filesystem::path& file);
// Loads its library as the loader does.
DriverProbe probeDriver(const std::filesystem::path& file);

// Loads a driver's library by path, or by a name that the dynamic linker searches for. Returns what is wrong with it,
// as the end of a sentence; empty: it is a Vulkan driver that can create instances.
std::string probeDriverLibrary(const std::string& library);

// A library of NVIDIA's driver that may be on this machine, and why it does not work (as probeDriverLibrary says).
struct NvidiaLibrary {
  std::string library, error;
  bool isMissing = false;  // there is no such library
};
// Tries the names under which NVIDIA's Vulkan driver is installed, up to the first that works.
std::vector<NvidiaLibrary> probeNvidiaLibraries();

}  // namespace latelight::vk
