// Encodes and decodes NumPy array files, version 1.0 (NEP 1), in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "output/aov.h"
#include "output/read.h"

namespace latelight::output {

// Writes float32 of shape (H, W) or (H, W, channels), or uint32 of shape (H, W) for ids; little-endian, C order.
std::vector<std::byte> encodeNpy(const AovImage& image);
// Writes an array of at least one axis. `type` is NumPy's, such as "<f4" or "|b1".
std::vector<std::byte> encodeNpy(std::string_view type, std::span<const uint64_t> shape,
                                 std::span<const std::byte> data);

// Throws Error(BadInput) that names `path`.
ReadImage decodeNpy(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace latelight::output
