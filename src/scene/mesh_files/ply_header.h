// The header of a PLY file (Turk, "The PLY Polygon File Format", 1994): its elements and their properties.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace latelight::scene::mesh_files {

enum class PlyEncoding : uint8_t { Ascii, LittleEndian, BigEndian };
enum class PlyType : uint8_t { None, Int8, Uint8, Int16, Uint16, Int32, Uint32, Float, Double };

size_t sizeOf(PlyType type);
inline bool isInteger(PlyType type) {
  return type != PlyType::Float && type != PlyType::Double;
}

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::None;
  PlyType countType = PlyType::None;  // of a list's length; None: not a list
  bool isList() const { return countType != PlyType::None; }
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
  // Returns the index of the first property with one of the names, or -1.
  int find(std::initializer_list<std::string_view> names) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::Ascii;
  std::vector<PlyElement> elements;
  std::vector<std::string> textures;  // MeshLab's "comment TextureFile NAME"
  size_t bytes = 0;                   // the offset of the data
};

// Throws Error(BadInput) that names the line.
PlyHeader readPlyHeader(std::string_view text);

}  // namespace latelight::scene::mesh_files
