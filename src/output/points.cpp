#include "output/points.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/error.h"
#include "output/npy.h"
#include "output/zip_archive.h"

namespace latelight::output {

namespace {

static_assert(std::endian::native == std::endian::little, "values are written as they lie in memory");

struct ValueType {
  size_t bytes;
  char kind;             // as in NumPy: f, u
  std::string_view ply;  // Open3D reads uint16 but skips ushort, its other name
};

ValueType typeOf(const PointField& field) {
  constexpr ValueType kTypes[] = {{4, 'f', "float"},
                                  {8, 'f', "double"},
                                  {1, 'u', "uchar"},
                                  {2, 'u', "uint16"},
                                  {4, 'u', "uint"}};  // in the order of the variant
  return kTypes[field.values.index()];
}

std::span<const std::byte> bytesOf(const PointField& field) {
  return std::visit([](const auto& values) { return std::as_bytes(values); }, field.values);
}

size_t countOf(std::span<const PointField> fields) {
  return fields.empty() ? 0 : bytesOf(fields.front()).size() / typeOf(fields.front()).bytes;
}

// Returns the header, and then one packed record per point.
std::vector<std::byte> withRecords(const std::string& header, std::span<const PointField> fields) {
  size_t record = 0;
  for (const PointField& field : fields) record += typeOf(field).bytes;
  const size_t count = countOf(fields);
  std::vector<std::byte> file(header.size() + record * count);
  std::memcpy(file.data(), header.data(), header.size());
  std::byte* at = file.data() + header.size();
  for (const PointField& field : fields) {
    const size_t bytes = typeOf(field).bytes;
    const std::byte* from = bytesOf(field).data();
    for (size_t i = 0; i < count; ++i) std::memcpy(at + i * record, from + i * bytes, bytes);
    at += bytes;
  }
  return file;
}

// Binary PLY 1.0 (Turk 1994, "The PLY Polygon File Format").
std::vector<std::byte> encodePly(std::span<const PointField> fields) {
  std::string header = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", countOf(fields));
  for (const PointField& field : fields) header += fmt::format("property {} {}\n", typeOf(field).ply, field.name);
  return withRecords(header + "end_header\n", fields);
}

// Binary PCD 0.7, the format of the Point Cloud Library.
std::vector<std::byte> encodePcd(std::span<const PointField> fields) {
  std::string names, sizes, kinds, counts;
  for (const PointField& field : fields) {
    const ValueType type = typeOf(field);
    names += " " + field.name;
    sizes += fmt::format(" {}", type.bytes);
    kinds += type.kind == 'f' ? " F" : " U";
    counts += " 1";
  }
  const size_t count = countOf(fields);
  return withRecords(
      fmt::format("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\nCOUNT{}\n"
                  "WIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
                  names, sizes, kinds, counts, count, count),
      fields);
}

// Four floats per point (Geiger et al. 2013, "Vision meets Robotics: The KITTI Dataset").
std::vector<std::byte> encodeKitti(std::span<const PointField> fields) {
  std::vector<PointField> four;
  for (const std::string_view name : {"x", "y", "z", "intensity"}) {
    const auto field = std::ranges::find(fields, name, &PointField::name);
    if (field == fields.end() || !std::holds_alternative<std::span<const float>>(field->values))
      badUsage("a .bin file has x, y, z and intensity as floats, but the points have no such {}", name);
    four.push_back(*field);
  }
  return withRecords("", four);
}

std::vector<std::byte> encodeNpz(std::span<const PointField> fields) {
  ZipArchive archive;
  const uint64_t shape[] = {countOf(fields)};
  for (const PointField& field : fields) {
    const ValueType type = typeOf(field);
    archive.add(
        field.name + ".npy",
        encodeNpy(fmt::format("{}{}{}", type.bytes == 1 ? '|' : '<', type.kind, type.bytes), shape, bytesOf(field)));
  }
  return archive.finish();
}

}  // namespace

std::vector<std::byte> encodePoints(std::string_view format, std::span<const PointField> fields) {
  for (const PointField& field : fields)
    if (bytesOf(field).size() != countOf(fields) * typeOf(field).bytes)
      badUsage("all fields of points must have as many values, but \"{}\" differs from \"{}\"", field.name,
               fields.front().name);
  if (format == "ply") return encodePly(fields);
  if (format == "pcd") return encodePcd(fields);
  if (format == "bin") return encodeKitti(fields);
  if (format == "npz") return encodeNpz(fields);
  const std::string endings = fmt::format(".{}", fmt::join(kPointFormats, ", ."));
  if (format.empty()) badUsage("the file's name has no extension: points are written as {}", endings);
  badUsage("points are written as {}, not \".{}\"", endings, format);
}

}  // namespace latelight::output
