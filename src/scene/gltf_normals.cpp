#include <cmath>

#include "scene/gltf_vertices.h"

namespace latelight::scene::gltf {
namespace {

template <typename T>
void unshare(std::vector<T>& stream, const std::vector<uint32_t>& indices) {
  if (stream.empty()) return;
  std::vector<T> out(indices.size());
  for (size_t i = 0; i < indices.size(); ++i) out[i] = stream[indices[i]];
  stream = std::move(out);
}

// Twice the triangle's area long; doubles, because tiny triangles' products underflow.
glm::dvec3 areaNormal(const Vertices& v, const uint32_t* corner) {
  glm::dvec3 a = v.positions[corner[0]], b = v.positions[corner[1]], c = v.positions[corner[2]];
  return glm::cross(b - a, c - a);
}

vec3 unitOrUp(glm::dvec3 normal) {
  double length = glm::length(normal);
  return length > 0 && std::isfinite(length) ? vec3(normal / length) : vec3(0, 0, 1);
}

bool isUsable(vec3 normal) {
  float length2 = glm::dot(normal, normal);
  return length2 > 1e-30f && std::isfinite(length2);
}

}  // namespace

void makeFlatNormals(Vertices& v, std::vector<uint32_t>& indices) {
  unshare(v.positions, indices);
  unshare(v.colors, indices);
  unshare(v.uv[0], indices);
  unshare(v.uv[1], indices);
  unshare(v.origin, indices);
  v.tangents.clear();  // without normals, tangents mean nothing
  for (size_t i = 0; i < indices.size(); ++i) indices[i] = uint32_t(i);
  v.normals.resize(indices.size());
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    vec3 normal = unitOrUp(areaNormal(v, &indices[i]));
    for (size_t corner = i; corner < i + 3; ++corner) v.normals[corner] = normal;
  }
}

void repairNormals(Vertices& v, const std::vector<uint32_t>& indices) {
  std::vector<bool> broken(v.normals.size());
  bool any = false;
  for (size_t i = 0; i < v.normals.size(); ++i) {
    if (isUsable(v.normals[i]))
      v.normals[i] = glm::normalize(v.normals[i]);
    else
      broken[i] = any = true;
  }
  if (!any) return;
  std::vector<glm::dvec3> sums(v.normals.size(), glm::dvec3(0));
  for (size_t i = 0; i + 2 < indices.size(); i += 3) {
    glm::dvec3 normal = areaNormal(v, &indices[i]);
    for (size_t corner = i; corner < i + 3; ++corner) sums[indices[corner]] += normal;
  }
  for (size_t i = 0; i < v.normals.size(); ++i)
    if (broken[i]) v.normals[i] = unitOrUp(sums[i]);
}

}  // namespace latelight::scene::gltf
