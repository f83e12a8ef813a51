// The driver files that the Vulkan loader reads, found and tried without it. Linux; the loader's
// LoaderDriverInterface.md documents the locations and their order.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace latelight::vk {

struct DriverFiles {
  std::string where;                         // in words: the variable or the folders that were searched
  std::vector<std::filesystem::path> files;  // in the loader's order; a variable may name files that don't exist
};
DriverFiles findDriverFiles();

struct DriverProbe {
  std::string library;  // as the file names it; empty where it can't be read
  std::string error;    // what is wrong, as the end of a sentence; empty: the driver loads
};
DriverProbe probeDriver(const std::filesystem::path& file);

}  // namespace latelight::vk
