// PNG files (ISO/IEC 15948) in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "output/aov.h"
#include "output/read.h"

namespace latelight::output {

// The meaning of the stored numbers.
enum class PngLight { Srgb, Data };

// Rows of `channels` (1 grey, 2 grey and alpha, 3 RGB, 4 RGBA) times `bits` / 8 bytes, 16 bit in the machine's order.
// The same input gives the same bytes, whatever the number of threads.
std::vector<std::byte> encodePng(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits,
                                 const std::byte* pixels, PngLight light);

// An AOV by its PngCoding. Colour is un-premultiplied and clamped. The AOV must have a coding.
std::vector<std::byte> encodePng(const AovImage& image);
std::vector<std::byte> encodePng(const Picture& picture);

// Throws Error(BadInput) that names `path`.
ReadImage decodePng(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace latelight::output
