// Encodes and decodes NumPy array files, version 1.0 (NEP 1), in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "output/aov.h"
#include "output/read.h"

namespace latelight::output {

// Writes float32 of shape (H, W) or (H, W, channels), or uint32 of shape (H, W) for ids; little-endian, C order.
std::vector<std::byte> encodeNpy(const AovImage& image);

// Throws Error(BadInput) that names `path`.
ReadImage decodeNpy(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace latelight::output
