// Files with compressed geometry, encoded by meshoptimizer and by Draco.
#pragma once

#include <draco/compression/encode.h>
#include <meshoptimizer.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "gltf_builder.h"

namespace latelight::scene::test {

inline constexpr size_t kSide = 9, kVertices = kSide * kSide;

// The vertices and triangles of a bent square.
struct Grid {
  std::vector<vec3> positions, normals;
  std::vector<uint32_t> indices;
  Grid() {
    for (size_t y = 0; y < kSide; ++y)
      for (size_t x = 0; x < kSide; ++x) {
        float u = float(x) / (kSide - 1), v = float(y) / (kSide - 1);
        positions.push_back({u, v, u * u / 2});
        normals.push_back(glm::normalize(vec3(-u, 0, 1)));
      }
    for (uint32_t y = 0; y + 1 < kSide; ++y)
      for (uint32_t x = 0; x + 1 < kSide; ++x) {
        uint32_t i = y * uint32_t(kSide) + x, up = i + uint32_t(kSide);
        indices.insert(indices.end(), {i, i + 1, up, up, i + 1, up + 1});
      }
  }
};

// A bufferView that meshoptimizer compressed, over a fallback buffer without bytes.
inline int meshoptView(GltfBuilder& b, const std::vector<unsigned char>& encoded, size_t count, size_t stride,
                       const char* mode, const char* filter) {
  int data = b.view(encoded);
  json view = b.root["bufferViews"][size_t(data)];
  view["byteStride"] = stride;
  view["count"] = count;
  view["mode"] = mode;
  view["filter"] = filter;
  json outer = {{"buffer", 1}, {"byteLength", count * stride}, {"extensions", {{"EXT_meshopt_compression", view}}}};
  if (std::string(mode) == "ATTRIBUTES") outer["byteStride"] = stride;
  return b.add("bufferViews", outer);
}

template <typename T>
std::vector<unsigned char> encodeVertices(const std::vector<T>& values) {
  std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(values.size(), sizeof(T)));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), values.data(), values.size(), sizeof(T)));
  return out;
}

// A value as the filter EXPONENTIAL reads it, with a mantissa of 20 bits. The arguments of meshoptimizer's encoder
// depend on its version.
inline uint32_t exponentialOf(float value) {
  int exponent;
  std::frexp(value, &exponent);
  exponent -= 19;
  const int32_t mantissa = int32_t(std::lround(std::ldexp(value, -exponent)));
  return uint32_t(exponent) << 24 | (uint32_t(mantissa) & 0xFFFFFF);
}

inline void finishMeshopt(GltfBuilder& b) {
  b.root["buffers"] = {{{"byteLength", b.buffer.size()}},
                       {{"byteLength", 1 << 20}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  b.root["extensionsUsed"] = b.root["extensionsRequired"] = {"EXT_meshopt_compression", "KHR_mesh_quantization"};
}

inline GltfBuilder meshoptFile() {
  Grid grid;
  GltfBuilder b;
  int p = b.accessor(meshoptView(b, encodeVertices(grid.positions), kVertices, 12, "ATTRIBUTES", "NONE"), kFloat,
                     "VEC3", kVertices);

  std::vector<vec4> four;
  for (vec3 n : grid.normals) four.push_back(vec4(n, 0));
  std::vector<std::array<int16_t, 4>> octahedral(kVertices);
  meshopt_encodeFilterOct(octahedral.data(), kVertices, 8, 12, &four[0].x);
  int n = b.accessor(meshoptView(b, encodeVertices(octahedral), kVertices, 8, "ATTRIBUTES", "OCTAHEDRAL"), kShort,
                     "VEC3", kVertices);
  b.root["accessors"][size_t(n)]["normalized"] = true;

  std::vector<std::array<uint32_t, 2>> exponential;
  for (vec3 q : grid.positions) exponential.push_back({exponentialOf(q.x), exponentialOf(q.y)});
  int t = b.accessor(meshoptView(b, encodeVertices(exponential), kVertices, 8, "ATTRIBUTES", "EXPONENTIAL"), kFloat,
                     "VEC2", kVertices);

  std::vector<unsigned char> encoded(meshopt_encodeIndexBufferBound(grid.indices.size(), kVertices));
  encoded.resize(meshopt_encodeIndexBuffer(encoded.data(), encoded.size(), grid.indices.data(), grid.indices.size()));
  int i = b.accessor(meshoptView(b, encoded, grid.indices.size(), 2, "TRIANGLES", "NONE"), kUnsignedShort, "SCALAR",
                     grid.indices.size());
  b.mesh({{"attributes", {{"POSITION", p}, {"NORMAL", n}, {"TEXCOORD_0", t}}}, {"indices", i}});
  finishMeshopt(b);
  return b;
}

// The grid as a Draco mesh, with the ids of its attributes.
inline GltfBuilder dracoFile(int method) {
  Grid grid;
  draco::Mesh mesh;
  mesh.set_num_points(uint32_t(kVertices));
  mesh.SetNumFaces(grid.indices.size() / 3);
  for (uint32_t f = 0; f < mesh.num_faces(); ++f)
    mesh.SetFace(draco::FaceIndex(f),
                 {draco::PointIndex(grid.indices[f * 3]), draco::PointIndex(grid.indices[f * 3 + 1]),
                  draco::PointIndex(grid.indices[f * 3 + 2])});
  auto attribute = [&](draco::GeometryAttribute::Type type, const std::vector<vec3>& values) {
    draco::GeometryAttribute description;
    description.Init(type, nullptr, 3, draco::DT_FLOAT32, false, sizeof(vec3), 0);
    int id = mesh.AddAttribute(description, true, uint32_t(kVertices));
    for (uint32_t v = 0; v < kVertices; ++v)
      mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), &values[v]);
    return int(mesh.attribute(id)->unique_id());
  };
  int position = attribute(draco::GeometryAttribute::POSITION, grid.positions);
  int normal = attribute(draco::GeometryAttribute::NORMAL, grid.normals);
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 10);
  draco::EncoderBuffer encoded;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &encoded).ok());

  GltfBuilder b;
  int view = b.view(std::as_bytes(std::span(encoded.data(), encoded.size())));
  auto bare = [&](Component component, const char* type, size_t count) {
    return b.add("accessors", {{"componentType", component}, {"type", type}, {"count", count}});
  };
  int p = bare(kFloat, "VEC3", kVertices), n = bare(kFloat, "VEC3", kVertices),
      i = bare(kUnsignedShort, "SCALAR", grid.indices.size());
  json extension = {{"bufferView", view}, {"attributes", {{"POSITION", position}, {"NORMAL", normal}}}};
  b.mesh({{"attributes", {{"POSITION", p}, {"NORMAL", n}}},
          {"indices", i},
          {"extensions", {{"KHR_draco_mesh_compression", extension}}}});
  b.root["extensionsUsed"] = b.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return b;
}

}  // namespace latelight::scene::test
