// Reads PNG, OpenEXR and NPY files back as channels of numbers, for comparing images and for tests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::output {

enum class ChannelType : uint8_t { Unorm8, Unorm16, Half, Float, Double, Integer };

struct Channel {
  // EXR: the channel's own name. PNG, and NPY with up to four channels: Y; Y A; R G B; R G B A. NPY with more channels:
  // "0", "1", ...
  std::string name;
  ChannelType type = ChannelType::Float;
  // Unorm8 and Unorm16 (PNG) are in [0, 1]. All other types hold the stored number exactly.
  std::vector<double> values;  // width * height, rows from the top
};

struct ReadImage {
  uint32_t width = 0, height = 0;
  std::vector<Channel> channels;                     // as in the file
  const Channel* find(std::string_view name) const;  // null if absent
};

// Reads any PNG, a single-part EXR of scan lines or tiles (except luminance-chroma and deep ones), or an NPY of shape
// (H, W) or (H, W, C). Formats are recognized by their first bytes, not by file name. Throws Error(BadInput) that names
// the file and the problem.
ReadImage readImage(const std::filesystem::path& path);

}  // namespace latelight::output
