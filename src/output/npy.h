// NumPy's array files, version 1.0 (NEP 1), in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "output/aov.h"
#include "output/read.h"

namespace latelight::output {

// float32 of shape (H, W) or (H, W, channels), ids uint32 of shape (H, W); little endian, C order.
std::vector<std::byte> encodeNpy(const AovImage& image);

// Throws Error(BadInput) that names `path`.
ReadImage decodeNpy(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace latelight::output
