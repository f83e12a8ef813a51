// Reads the rows of a PLY file's elements, in all three encodings.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "scene/mesh_files/ply_header.h"

namespace latelight::scene::mesh_files {

class PlyRows {
 public:
  PlyRows(std::string_view file, const PlyHeader& header)
      : file_(file), start_(header.bytes), at_(header.bytes), encoding_(header.encoding) {}

  // Returns to the first row of the first element.
  void rewind() { at_ = start_; }
  // Begins an element. Throws Error(BadInput) if the rest of the file is too short for its rows.
  void begin(const PlyElement& element);
  // Reads the next row: value() and list() then return its properties.
  void next();
  // Reads all rows of the element, on all threads if they have the same number of bytes or are lines of text: calls
  // body(rows, i) for each row i, with the rows positioned at it, in any order. It may call it twice for a row.
  void forEach(const std::function<void(const PlyRows& rows, uint64_t i)>& body);
  // Reads all rows of an element, if each has three entries in the list and no other list, and all entries are below
  // `limit`. Otherwise it returns nothing and reads nothing.
  std::optional<std::vector<uint32_t>> readTriangles(int list, uint64_t limit);
  double value(int property) const { return values_[static_cast<size_t>(property)]; }
  const std::vector<double>& list(int property) const { return lists_[static_cast<size_t>(property)]; }
  uint64_t row() const { return row_; }  // of the element, from 1 on

 private:
  double read(PlyType type);
  double readText(PlyType type);
  [[noreturn]] void endsEarly() const;
  void readList(const PlyProperty& property, std::vector<double>& list);
  // Calls body(rows, i) for each row i of the element on all threads, if the rows are lines of text, and then returns
  // true. Returns false, and reads nothing, if they are not, if a row is invalid, or if `body` returns false.
  bool forEachLine(const std::function<bool(const PlyRows& rows, uint64_t i)>& body);
  std::vector<size_t> taskStarts() const;
  // The bytes of a row whose lists have `entries` entries; 0 if they are unknown.
  size_t rowBytes(uint32_t entries) const;
  template <typename T>
  bool readCorners(size_t offset, size_t stride, uint64_t limit, std::vector<uint32_t>& corners) const;

  const std::string_view file_;
  const size_t start_;  // of the rows
  size_t at_;
  const PlyEncoding encoding_;
  const PlyElement* element_ = nullptr;
  uint64_t row_ = 0;
  std::vector<double> values_;
  std::vector<std::vector<double>> lists_;
};

}  // namespace latelight::scene::mesh_files
