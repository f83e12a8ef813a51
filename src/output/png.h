// Encodes and decodes PNG files (ISO/IEC 15948) in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "output/aov.h"
#include "output/read.h"

namespace latelight::output {

// The meaning of the stored numbers.
enum class PngLight { Srgb, Data };

struct PngLayout {
  uint32_t width = 0, height = 0;
  uint32_t channels = 4;  // 1 gray, 2 gray and alpha, 3 RGB, 4 RGBA
  uint32_t bits = 8;      // per channel, 8 or 16
  PngLight light = PngLight::Data;
};

// Writes the rows [begin, end) of an image to `out`. Values of 16 bits are in the machine's byte order. Called
// concurrently, and for some rows more than once.
using PngRows = std::function<void(size_t begin, size_t end, std::byte* out)>;

// The same pixels produce the same bytes, regardless of the number of threads.
std::vector<std::byte> encodePng(const PngLayout& layout, const PngRows& rows);
// `pixels` has all rows.
std::vector<std::byte> encodePng(uint32_t width, uint32_t height, uint32_t channels, uint32_t bits,
                                 const std::byte* pixels, PngLight light);

// Encodes an AOV by its PngCoding, which must not be None. Color is un-premultiplied and clamped.
std::vector<std::byte> encodePng(const AovImage& image);
std::vector<std::byte> encodePng(const Picture& picture);

// Throws Error(BadInput) that names `path`.
ReadImage decodePng(std::span<const std::byte> bytes, const std::filesystem::path& path);

}  // namespace latelight::output
