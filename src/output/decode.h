// Helpers that the readers of all formats share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "output/read.h"

namespace latelight::output {

// Returns Y; Y A; R G B; R G B A; for five channels or more "0", "1", ...
std::vector<std::string> usualChannels(uint64_t count);

// Returns an image whose values are all zero. Throws Error(BadInput) that names `path` if it would not fit in this
// machine's memory, because a broken header can declare any size.
ReadImage makeReadImage(uint64_t width, uint64_t height, const std::vector<std::string>& names, ChannelType type,
                        const std::filesystem::path& path);

}  // namespace latelight::output
