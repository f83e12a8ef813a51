// High dynamic range pictures: Radiance .hdr and OpenEXR .exr files to floats.
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

// The most pixels a picture may have (16384 x 8192: 2 GiB as floats), and the longest side.
inline constexpr uint64_t kMostPicturePixels = uint64_t{1} << 27;
inline constexpr uint32_t kLongestPictureSide = 65536;

// The file's values as they are, NaN, infinities and negatives included; alpha is 1 where the file has none. The format
// is recognized by the contents, not by the name. Throws Error(BadInput) that names the file and what is wrong in it.
FloatImage readPicture(const std::filesystem::path& path);

// The same for bytes in memory; `name` is for errors.
FloatImage decodePicture(std::span<const std::byte> bytes, const std::string& name);

// Radiance's RGBE (Ward 1991, Graphics Gems II, "Real Pixels"): flat, old run lengths and new ones; rows in any of the
// four orders of -Y/+Y and +X/-X. EXPOSURE is not divided out: neither three.js nor the Khronos viewer does.
// (picture_radiance.cpp)
FloatImage decodeRadiance(std::span<const std::byte> bytes, const std::string& name);

// From the header, before anything is decoded: throws Error(BadInput) if a picture is larger than that, and
// Error(DeviceLost) if the limit on memory does not allow its floats.
void checkPictureSize(int64_t width, int64_t height, const std::string& name);

// OpenEXR: scan lines or tiles, the first of several parts; R G B or Y, in half, float or uint, with or without A, and
// where there are no such channels, the first layer with R G B. The picture is the display window. (picture_exr.cpp)
FloatImage decodeExr(std::span<const std::byte> bytes, const std::string& name);

}  // namespace latelight::scene
