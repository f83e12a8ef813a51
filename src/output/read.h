// Pictures read back from PNG, OpenEXR and NPY files, as channels of numbers: for comparing, and for the tests.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::output {

enum class ChannelType : uint8_t { Unorm8, Unorm16, Half, Float, Double, Integer };

struct Channel {
  // EXR: its own. PNG, and NPY of up to four channels: Y; Y A; R G B; R G B A. NPY with more: "0", "1", ...
  std::string name;
  ChannelType type = ChannelType::Float;
  // Unorm8 and Unorm16 (PNG) are in [0, 1]; everything else is the stored number, exactly.
  std::vector<double> values;  // width * height, rows from the top
};

struct ReadImage {
  uint32_t width = 0, height = 0;
  std::vector<Channel> channels;                     // as in the file
  const Channel* find(std::string_view name) const;  // or nullptr
};

// Reads any PNG, a single-part EXR of scan lines or tiles (luminance-chroma and deep ones excepted), or an NPY of shape
// (H, W) or (H, W, C); recognized by their first bytes, not by name. Throws Error(BadInput) naming the file and what is
// wrong.
ReadImage readImage(const std::filesystem::path& path);

}  // namespace latelight::output
