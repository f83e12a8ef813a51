// Converts a primitive's vertices and indices to a triangle list.
#include <algorithm>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/draco.h"
#include "scene/gltf/vertices.h"

namespace latelight::scene::gltf {
namespace {

constexpr size_t kMaxVertices = std::numeric_limits<uint32_t>::max();

size_t trianglesOf(int mode, size_t corners) {
  if (mode == file::kTriangles) return corners / 3;
  bool strip = mode == file::kTriangleStrip || mode == file::kTriangleFan;
  return strip && corners >= 3 ? corners - 2 : 0;
}

// Unrolls strips and fans to a triangle list. Every second triangle of a strip has the opposite winding (glTF 2.0,
// 3.7.2.1).
std::vector<uint32_t> unroll(std::vector<uint32_t> corners, int mode) {
  size_t triangles = trianglesOf(mode, corners.size());
  if (mode == file::kTriangles) {
    corners.resize(triangles * 3);
    return corners;
  }
  std::vector<uint32_t> list(triangles * 3);
  for (size_t i = 0; i < triangles; ++i) {
    uint32_t* t = &list[i * 3];
    if (mode == file::kTriangleStrip)
      t[0] = corners[i], t[1] = corners[i + 1 + i % 2], t[2] = corners[i + 2 - i % 2];
    else
      t[0] = corners[i + 1], t[1] = corners[i + 2], t[2] = corners[0];
  }
  return list;
}

// Restricts the source to the range of vertices that it uses, because primitives may share one large buffer.
void narrow(Source& source, size_t vertexCount) {
  auto [least, most] = std::minmax_element(source.indices.begin(), source.indices.end());
  if (*most >= vertexCount) badInput("{} has the index {}, but {} vertices", source.name, *most, vertexCount);
  source.first = *least;
  source.count = size_t(*most) - *least + 1;
  if (source.first > 0)
    for (uint32_t& index : source.indices) index -= uint32_t(source.first);
}

}  // namespace

size_t triangleCount(const Document& document, const file::Primitive& primitive) {
  auto position = primitive.attributes.find("POSITION");
  if (position == primitive.attributes.end()) return 0;
  int corners = primitive.indices >= 0 ? primitive.indices : position->second;
  return trianglesOf(primitive.mode, document.model.accessors[size_t(corners)].count);
}

Source readSource(const Document& document, const file::Primitive& primitive, std::string name) {
  Source source{.name = std::move(name)};
  std::vector<uint32_t> corners;
  int mode = primitive.mode;
  if (primitive.draco) {
    DracoMesh mesh = decodeDraco(document, primitive, source.name);
    corners = std::move(mesh.indices);
    source.attributes = std::move(mesh.attributes);
    mode = file::kTriangles;  // Draco's faces are triangles, regardless of the primitive's mode
  } else if (primitive.indices >= 0) {
    Elements indices = resolve(document, primitive.indices);
    document.budget.charge(indices.count * sizeof(uint32_t), source.name);
    corners = readIndices(indices);
  }
  for (const auto& [key, accessor] : primitive.attributes)
    if (!source.attributes.contains(key)) source.attributes[key] = resolve(document, accessor);

  auto position = source.attributes.find("POSITION");
  if (position == source.attributes.end()) badInput("{} has no positions", source.name);
  size_t vertexCount = position->second.count;
  if (vertexCount > kMaxVertices) badInput("{} has more than {} vertices", source.name, kMaxVertices);
  for (const auto& [key, elements] : source.attributes)
    if (elements.count != vertexCount)
      badInput("{} has {} of {}, but {} positions", source.name, elements.count, key, vertexCount);
  if (corners.empty() && primitive.indices < 0) {
    document.budget.charge(vertexCount * sizeof(uint32_t), source.name);
    corners.resize(vertexCount);
    std::iota(corners.begin(), corners.end(), 0u);
  }
  if (const size_t rest = corners.size() % 3; mode == file::kTriangles && rest > 0)
    warn("{} has {} {}, which is not a multiple of 3: the last {} skipped", source.name, corners.size(),
         primitive.indices < 0 ? "vertices" : "indices", rest == 1 ? "one is" : "two are");
  source.indices = unroll(std::move(corners), mode);
  if (source.indices.empty()) badInput("{} has no triangles", source.name);
  narrow(source, vertexCount);
  return source;
}

}  // namespace latelight::scene::gltf
