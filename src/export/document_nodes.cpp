#include "export/document_nodes.h"

#include <utility>

#include "scene/decompose.h"

namespace latelight::exports {

using namespace scene;

namespace {

Json matrixOf(const dmat4& m) {
  Json array = Json::array();
  for (int i = 0; i < 16; ++i) array.push_back(m[i / 4][i % 4]);
  return array;
}

template <int N>
Json numbersOf(const glm::vec<N, double>& v) {
  Json array = Json::array();
  for (int i = 0; i < N; ++i) array.push_back(v[i]);
  return array;
}

}  // namespace

int DocumentNodes::add(Json node, int parent) {
  const auto index = static_cast<int>(document.add("nodes", std::move(node)));
  parents.push_back(parent);
  if (parent >= 0) arrayIn(at(parent), "children").push_back(index);
  return index;
}

dmat4 DocumentNodes::placeInFile(int node) const {
  return inFile(places[size_t(node)]);
}

dmat4 inFile(const dmat4& toWorld) {
  return toGltfFromWorld() * toWorld;
}

void setMatrix(Json& node, const dmat4& m) {
  if (m != dmat4(1)) node["matrix"] = matrixOf(m);
}

void setTransform(Json& node, const RigNode& source) {
  if (source.hasMatrix) return setMatrix(node, source.matrix);
  if (source.translation != dvec3(0)) node["translation"] = numbersOf(source.translation);
  if (source.rotation != glm::dvec4(0, 0, 0, 1)) node["rotation"] = numbersOf(source.rotation);
  if (source.scale != dvec3(1)) node["scale"] = numbersOf(source.scale);
}

void setTransform(Json& node, const dmat4& local, dvec3 scaleSigns) {
  setTransform(node, nodeWithTransform(local, scaleSigns));
}

}  // namespace latelight::exports
