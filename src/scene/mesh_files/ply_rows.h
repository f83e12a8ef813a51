// Reads the rows of a PLY file's elements, in all three encodings.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "scene/mesh_files/ply_header.h"

namespace latelight::scene::mesh_files {

class PlyRows {
 public:
  PlyRows(std::string_view file, const PlyHeader& header)
      : file_(file), at_(header.bytes), encoding_(header.encoding) {}

  // Begins an element. Throws Error(BadInput) if the rest of the file is too short for its rows.
  void begin(const PlyElement& element);
  // Reads the next row: value() and list() then return its properties.
  void next();
  double value(int property) const { return values_[static_cast<size_t>(property)]; }
  const std::vector<double>& list(int property) const { return lists_[static_cast<size_t>(property)]; }
  uint64_t row() const { return row_; }  // of the element, from 1 on

 private:
  double read(PlyType type);
  double readText(PlyType type);
  [[noreturn]] void endsEarly() const;
  void readList(const PlyProperty& property, std::vector<double>& list);

  const std::string_view file_;
  size_t at_;
  const PlyEncoding encoding_;
  const PlyElement* element_ = nullptr;
  uint64_t row_ = 0;
  std::vector<double> values_;
  std::vector<std::vector<double>> lists_;
};

}  // namespace latelight::scene::mesh_files
