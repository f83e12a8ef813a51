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
};
DriverProbe probeDriver(const std::filesystem::path& file);

}  // namespace latelight::vk
