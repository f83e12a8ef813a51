// Encodes and decodes PNG files (ISO/IEC 15948) in memory.
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

// Pixels are rows of `channels` (1 gray, 2 gray and alpha, 3 RGB, 4 RGBA) times `bits` / 8 bytes; 16 bit values are in
// the machine's byte order. The same input produces the same bytes, regardless of the number of threads.
std::vector<std::byte> encodePng(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits,
                                 const std::byte* pixels, PngLight light);

// Encodes an AOV by its PngCoding, which must not be None. Color is un-premultiplied and clamped.
std::vector<std::byte> encodePng(const AovImage& image);
std::vector<std::byte> encodePng(const Picture& picture);

// Throws Error(BadInput) that names `path`.
ReadImage decodePng(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace latelight::output
