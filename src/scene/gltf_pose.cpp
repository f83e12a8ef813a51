// The pose at rest: morph targets by their default weights (glTF 2.0, 3.7.2.2), skins by their joints' nodes (3.7.3).
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "scene/gltf_vertices.h"

namespace latelight::scene::gltf {
namespace {

template <int N>
void addDeltas(const Elements& deltas, const Source& source, float weight, std::vector<glm::vec<N, float>>& stream) {
  if (stream.empty()) return;
  std::vector<glm::vec<N, float>> values = readFinite<N>(deltas, source.first, source.count);
  for (size_t i = 0; i < stream.size(); ++i) stream[i] += values[i] * weight;
}

void addTarget(const std::string& key, const Elements& deltas, const Source& source, float weight, Vertices& v) {
  if (key == "POSITION") return addDeltas(deltas, source, weight, v.positions);
  if (key == "NORMAL") return addDeltas(deltas, source, weight, v.normals);
  if (key == "TANGENT") return addDeltas(deltas, source, weight, v.tangents);  // three components: w stays
  if (key == "TEXCOORD_0") return addDeltas(deltas, source, weight, v.uv[0]);
  if (key == "TEXCOORD_1") return addDeltas(deltas, source, weight, v.uv[1]);
  if (key == "COLOR_0") return addDeltas(deltas, source, weight, v.colors);
}

// From bind space to the file's own frame, of each joint. The skinned mesh's own node does not count (3.7.3.3).
std::vector<mat4> jointMatrices(const Document& document, const Hierarchy& hierarchy, int index) {
  const tinygltf::Skin& skin = document.model.skins[size_t(index)];
  if (skin.joints.empty()) badInput("skins[{}] has no joints", index);
  std::vector<mat4> inverseBind(skin.joints.size(), mat4(1));
  if (skin.inverseBindMatrices >= 0) {
    Elements elements = resolve(document, skin.inverseBindMatrices);
    if (elements.count < skin.joints.size())
      badInput("skins[{}] has {} joints but {} inverse bind matrices", index, skin.joints.size(), elements.count);
    document.budget.charge(elements.count * sizeof(mat4), elements.name);
    inverseBind = readMatrices(elements);
  }
  std::vector<mat4> matrices(skin.joints.size());
  for (size_t i = 0; i < matrices.size(); ++i)
    matrices[i] = mat4(hierarchy.world[size_t(skin.joints[i])] * glm::dmat4(inverseBind[i]));
  return matrices;
}

// One JOINTS_n and WEIGHTS_n: four more influences.
struct Influences {
  std::vector<glm::uvec4> joints;
  std::vector<vec4> weights;
};

std::vector<Influences> readInfluences(const Source& source, size_t jointCount, int skin) {
  std::vector<Influences> sets;
  for (int n = 0;; ++n) {
    auto joints = source.attributes.find(fmt::format("JOINTS_{}", n));
    auto weights = source.attributes.find(fmt::format("WEIGHTS_{}", n));
    if (joints == source.attributes.end() || weights == source.attributes.end()) return sets;
    Elements normalized = weights->second;
    normalized.normalized = true;
    sets.push_back({readJoints(joints->second, source.first, source.count),
                    readFinite<4>(normalized, source.first, source.count)});
    for (const glm::uvec4& four : sets.back().joints)
      for (int c = 0; c < 4; ++c)
        if (four[c] >= jointCount)
          badInput("{} names joint {} of skins[{}], which has {}", source.name, four[c], skin, jointCount);
  }
}

// Weights should add up to 1, and after quantisation don't quite.
mat4 blend(const std::vector<Influences>& sets, const std::vector<mat4>& joints, size_t vertex) {
  mat4 sum(0);
  float total = 0;
  for (const Influences& set : sets) {
    for (int c = 0; c < 4; ++c) {
      float weight = set.weights[vertex][c];
      if (weight == 0) continue;
      sum += joints[set.joints[vertex][c]] * weight;
      total += weight;
    }
  }
  return total > 0 ? sum * (1.0f / total) : joints[sets[0].joints[vertex].x];
}

}  // namespace

void applyMorphTargets(const Document& document, const tinygltf::Primitive& primitive, const Source& source,
                       const std::vector<double>& weights, Vertices& vertices) {
  size_t count = std::min(weights.size(), primitive.targets.size());
  for (size_t t = 0; t < count; ++t) {
    if (weights[t] == 0) continue;
    for (const auto& [key, accessor] : primitive.targets[t]) {
      Elements deltas = resolve(document, accessor);
      if (deltas.count < source.first + source.count)
        badInput("{}.targets[{}] has {} of {}, too few for its vertices", source.name, t, deltas.count, key);
      document.budget.charge(source.count * sizeof(vec4), source.name);
      addTarget(key, deltas, source, float(weights[t]), vertices);
    }
  }
}

void applySkin(const Document& document, const Hierarchy& hierarchy, int skin, const Source& source, Vertices& v) {
  std::vector<mat4> joints = jointMatrices(document, hierarchy, skin);
  std::vector<Influences> sets = readInfluences(source, joints.size(), skin);
  if (sets.empty()) return;
  for (size_t i = 0; i < v.positions.size(); ++i) {
    mat4 m = blend(sets, joints, i);
    v.positions[i] = vec3(m * vec4(v.positions[i], 1));
    if (!v.tangents.empty()) v.tangents[i] = vec4(glm::mat3(m) * vec3(v.tangents[i]), v.tangents[i].w);
    if (v.normals.empty()) continue;
    // The cofactor matrix: the inverse transpose times the determinant, and fine where that is 0.
    vec3 x(m[0]), y(m[1]), z(m[2]);
    vec3 n = v.normals[i];
    float sign = glm::dot(x, glm::cross(y, z)) < 0 ? -1.0f : 1.0f;
    v.normals[i] = (glm::cross(y, z) * n.x + glm::cross(z, x) * n.y + glm::cross(x, y) * n.z) * sign;
  }
}

}  // namespace latelight::scene::gltf
