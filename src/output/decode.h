// Shared by the readers of all formats.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "output/read.h"

namespace latelight::output {

// Y; Y A; R G B; R G B A; from five channels on "0", "1", ...
std::vector<std::string> usualChannels(uint64_t count);

// All values zero. Throws Error(BadInput) that names `path` where it would not fit in this machine's memory: a broken
// header can ask for any size.
ReadImage makeReadImage(uint64_t width, uint64_t height, const std::vector<std::string>& names, ChannelType type,
                        const std::filesystem::path& path);

}  // namespace latelight::output
