// Encodes point clouds: binary PLY and PCD, KITTI's .bin and NumPy's .npz.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace latelight::output {

// One value per point.
struct PointField {
  std::string name;
  std::variant<std::span<const float>, std::span<const double>, std::span<const uint8_t>, std::span<const uint16_t>,
               std::span<const uint32_t>>
      values;
};

// The names of the formats, which are the extensions of their files.
inline constexpr std::string_view kPointFormats[] = {"ply", "pcd", "bin", "npz"};

// All fields have as many values. PLY, PCD and NPZ contain all fields in their order; bin contains x, y, z and
// intensity as floats. Throws Error(Usage) if there is no such format or no such field.
std::vector<std::byte> encodePoints(std::string_view format, std::span<const PointField> fields);

}  // namespace latelight::output
