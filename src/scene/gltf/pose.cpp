// Deforms a primitive's vertices by its morph targets (glTF 2.0, 3.7.2.2) and its skin's joints (3.7.3).
#include <algorithm>

#include "base/error.h"
#include "scene/gltf/skin.h"
#include "scene/gltf/vertices.h"

namespace latelight::scene::gltf {
namespace {

std::string nameOf(size_t target, const std::string& key) {
  return fmt::format("targets[{}].{}", target, key);
}

// One attribute of a morph target.
struct Deltas {
  const Document& document;
  const Source& source;
  std::string name;
  Elements elements;

  template <int N>
  void addTo(std::vector<glm::vec<N, float>>& stream, float weight) const {
    if (stream.empty()) return;
    const auto values = readAttribute<N>(document, source, name, elements);
    for (size_t i = 0; i < stream.size(); ++i) stream[i] += values[i] * weight;
  }
};

void addTarget(const std::string& key, const Deltas& deltas, float weight, Vertices& v) {
  if (key == "TEXCOORD_0") return deltas.addTo(v.uv[0], weight);
  if (key == "TEXCOORD_1") return deltas.addTo(v.uv[1], weight);
  if (key == "COLOR_0") return deltas.addTo(v.colors, weight);
}

bool isGeometry(const std::string& key) {
  return key == "POSITION" || key == "NORMAL" || key == "TANGENT";
}

Elements targetElements(const Document& document, const Source& source, size_t target, const std::string& key,
                        int accessor) {
  Elements deltas = resolve(document, accessor);
  checkType(deltas, AccessorUse::MorphTarget, key, fmt::format("{}.{}", source.name, nameOf(target, key)));
  if (deltas.count < source.first + source.count)
    badInput("{}.targets[{}] has {} of {}, too few for its vertices", source.name, target, deltas.count, key);
  document.budget.charge(source.count * sizeof(vec4), source.name);
  return deltas;
}

// A JOINTS_n and WEIGHTS_n pair: four more influences per vertex.
struct Influences {
  std::vector<glm::uvec4> joints;
  std::vector<vec4> weights;
};

// A joint index out of range is an error only if its weight is above 0, because exporters leave arbitrary values in
// unused components.
void checkJoints(const Source& source, size_t jointCount, int skin, Influences& influences) {
  for (size_t i = 0; i < influences.joints.size(); ++i)
    for (int c = 0; c < 4; ++c) {
      uint32_t& joint = influences.joints[i][c];
      if (joint < jointCount) continue;
      if (influences.weights[i][c] > 0)
        badInput("{} names joint {} of skins[{}], which has {}", source.name, joint, skin, jointCount);
      joint = 0;
    }
}

std::vector<Influences> readInfluences(const Document& document, const Source& source, size_t jointCount, int skin) {
  std::vector<Influences> sets;
  for (int n = 0;; ++n) {
    auto joints = source.attributes.find(fmt::format("JOINTS_{}", n));
    auto weights = source.attributes.find(fmt::format("WEIGHTS_{}", n));
    if (joints == source.attributes.end() || weights == source.attributes.end()) return sets;
    for (const auto& set : {joints, weights})
      checkType(set->second, AccessorUse::Vertices, set->first, fmt::format("{}.{}", source.name, set->first));
    document.budget.charge(source.count * 2 * (sizeof(glm::uvec4) + sizeof(vec4)), source.name);
    Elements normalized = weights->second;
    normalized.normalized = true;
    sets.push_back({readJoints(joints->second, source.first, source.count),
                    readAttribute<4>(document, source, weights->first, normalized)});
    checkJoints(source, jointCount, skin, sets.back());
  }
}

template <typename T>
std::vector<T> gather(const std::vector<T>& stream, const std::vector<uint32_t>& origin) {
  std::vector<T> out;
  if (stream.empty()) return out;
  out.reserve(origin.size());
  for (uint32_t vertex : origin) out.push_back(stream[vertex]);
  return out;
}

}  // namespace

void morphCoordinatesAndColors(const Document& document, const file::Primitive& primitive, const Source& source,
                               const std::vector<double>& weights, Vertices& vertices) {
  size_t count = std::min(weights.size(), primitive.targets.size());
  for (size_t t = 0; t < count; ++t) {
    if (weights[t] == 0) continue;
    for (const auto& [key, accessor] : primitive.targets[t])
      if (!isGeometry(key))
        addTarget(key, {document, source, nameOf(t, key), targetElements(document, source, t, key, accessor)},
                  float(weights[t]), vertices);
  }
}

void readSkinWeights(const Document& document, int skin, const Source& source, const std::vector<uint32_t>& origin,
                     Deformation& deformation) {
  const size_t jointCount = document.model.skins[size_t(skin)].joints.size();
  const std::vector<Influences> sets = readInfluences(document, source, jointCount, skin);
  if (sets.empty()) return;
  deformation.skin = skin;
  deformation.influences = uint32_t(4 * sets.size());
  for (uint32_t vertex : origin) {
    for (const Influences& set : sets)
      for (int c = 0; c < 4; ++c) {
        deformation.joints.push_back(set.joints[vertex][c]);
        deformation.jointWeights.push_back(set.weights[vertex][c]);
      }
    normalizeWeights(std::span(deformation.jointWeights).last(deformation.influences));
  }
}

MorphTarget readMorphTarget(const Document& document, const file::Primitive& primitive, size_t index,
                            const Source& source, const std::vector<uint32_t>& origin) {
  MorphTarget deltas;
  for (const auto& [key, accessor] : primitive.targets[index]) {
    if (!isGeometry(key)) continue;
    const Elements elements = targetElements(document, source, index, key, accessor);
    document.budget.charge(origin.size() * sizeof(vec3), source.name);
    std::vector<vec3>& stream = key == "POSITION" ? deltas.positions
                                : key == "NORMAL" ? deltas.normals
                                                  : deltas.tangents;
    stream = gather(readAttribute<3>(document, source, nameOf(index, key), elements), origin);
  }
  return deltas;
}

std::vector<mat4> restJoints(const Document& document, const Hierarchy& hierarchy, int index) {
  return jointMatrices(readSkin(document, hierarchy, index), {.world = hierarchy.world});
}

}  // namespace latelight::scene::gltf
