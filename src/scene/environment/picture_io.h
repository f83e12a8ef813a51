// High dynamic range images: decodes Radiance .hdr and OpenEXR .exr files to floats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/memory.h"

namespace latelight::scene {

struct EnvironmentMemory {
  static constexpr std::string_view kName = "an environment's image";
};

// RGBA, linear, rows from the top.
struct FloatImage {
  uint32_t width = 0, height = 0;
  CountedVector<float, EnvironmentMemory> pixels;  // 4 * width * height

  FloatImage() = default;
  FloatImage(uint32_t width, uint32_t height) : width(width), height(height), pixels(size_t{4} * width * height) {}
  float* at(size_t x, size_t y) { return pixels.data() + 4 * (y * width + x); }
  const float* at(size_t x, size_t y) const { return pixels.data() + 4 * (y * width + x); }
};

// The maximum number of pixels of an image (16384 x 8192: 2 GiB as floats), and the maximum side.
inline constexpr uint64_t kMaxPicturePixels = uint64_t{1} << 27;
inline constexpr uint32_t kLongestPictureSide = 65536;

// Reads the file's values unchanged, including NaN, infinities and negative values. Alpha is 1 if the file has none.
// The format is recognized by the contents, not by the name. Throws Error(BadInput) that names the file and the
// problem.
FloatImage readPicture(const std::filesystem::path& path);

// Decodes bytes in memory in the same way; `name` is for errors.
FloatImage decodePicture(std::span<const std::byte> bytes, const std::string& name);

// Decodes Radiance RGBE (Ward 1991, Graphics Gems II, "Real Pixels"): flat, or with old or new run-length encoding, and
// rows in any of the four orders of -Y/+Y and +X/-X. EXPOSURE is not divided out, as in three.js and the Khronos
// viewer. (picture_radiance.cpp)
FloatImage decodeRadiance(std::span<const std::byte> bytes, const std::string& name);

// Checks the size in a header before anything is decoded. Throws Error(BadInput) if the image exceeds the maximum size,
// and Error(OutOfMemory) if the memory limit does not allow its floats.
void checkPictureSize(int64_t width, int64_t height, const std::string& name);

// Decodes OpenEXR: scan lines or tiles, the first of several parts; R G B or Y, in half, float or uint, with or without
// A. If there are no such channels, it uses the first layer with R G B. The image is the display window.
// (picture_exr.cpp)
FloatImage decodeExr(std::span<const std::byte> bytes, const std::string& name);

}  // namespace latelight::scene
