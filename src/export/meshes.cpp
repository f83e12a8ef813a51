// Writes a mesh's vertices. Streams that hold only default values are omitted, as they were missing in the source.
// Deformed meshes are written undeformed, with their joints and morph targets.
#include "export/meshes.h"

#include <algorithm>
#include <cmath>

namespace latelight::exports {
namespace {

using namespace scene;

template <typename T, typename Get>
std::vector<T> streamOf(size_t count, const Get& get) {
  std::vector<T> stream(count);
  for (size_t i = 0; i < count; ++i) stream[i] = get(i);
  return stream;
}

template <typename T>
bool isAll(const std::vector<T>& stream, const T& value) {
  return std::ranges::all_of(stream, [&](const T& v) { return v == value; });
}

// Morph targets that a pose has applied change the lengths of tangents, and glTF requires unit ones.
vec4 unitTangent(const vec4& tangent) {
  const float length = glm::length(vec3(tangent));
  return length > 0 && std::abs(length - 1) > 1e-5f ? vec4(vec3(tangent) / length, tangent.w) : tangent;
}

// glTF requires unit tangents. Where the texture coordinates are degenerate there are none, and readers compute them.
bool areTangentsValid(const std::vector<vec4>& tangents) {
  return std::ranges::all_of(
      tangents, [](const vec4& t) { return std::abs(glm::length(vec3(t)) - 1) < 1e-3f && std::abs(t.w) == 1; });
}

}  // namespace

Json MeshWriter::attributesOf(const Mesh& mesh, bool omitsTangents) {
  const Deformation* deformation = mesh.deformation.get();
  const auto& positions = deformation ? deformation->positions : mesh.positions;
  const auto& attributes = deformation ? deformation->attributes : mesh.attributes;
  const size_t count = positions.size();
  Json out{{"POSITION", document_.addPositions(positions)}};
  if (!deformation || !deformation->flatNormals)
    out["NORMAL"] = document_.addVectors(streamOf<vec3>(count, [&](size_t i) { return attributes[i].normal; }));
  const auto tangents = streamOf<vec4>(count, [&](size_t i) { return unitTangent(attributes[i].tangent); });
  if (!omitsTangents && areTangentsValid(tangents)) out["TANGENT"] = document_.addVectors(tangents);
  const auto uv = streamOf<vec2>(count, [&](size_t i) { return attributes[i].uv0; });
  if (!isAll(uv, vec2(0))) out["TEXCOORD_0"] = document_.addVectors(uv);
  if (mesh.extras.empty()) return out;
  const auto uv1 = streamOf<vec2>(count, [&](size_t i) { return mesh.extras[i].uv1; });
  const auto colors = streamOf<vec4>(count, [&](size_t i) { return mesh.extras[i].color; });
  if (!isAll(uv1, vec2(0))) {
    if (!out.contains("TEXCOORD_0")) out["TEXCOORD_0"] = document_.addVectors(uv);  // sets are numbered without gaps
    out["TEXCOORD_1"] = document_.addVectors(uv1);
  }
  if (!isAll(colors, vec4(1))) out["COLOR_0"] = document_.addVectors(colors);
  return out;
}

void MeshWriter::addSkin(const Deformation& deformation, Json& attributes) {
  const size_t vertices = deformation.positions.size(), sets = deformation.influences / 4;
  for (size_t set = 0; set < sets; ++set) {
    std::vector<uint16_t> joints(4 * vertices);
    std::vector<vec4> weights(vertices);
    for (size_t v = 0; v < vertices; ++v)
      for (size_t k = 0; k < 4; ++k) {
        const size_t from = v * deformation.influences + 4 * set + k;
        weights[v][static_cast<int>(k)] = deformation.jointWeights[from];
        // glTF requires unused joints to be 0.
        if (deformation.jointWeights[from] > 0) joints[4 * v + k] = static_cast<uint16_t>(deformation.joints[from]);
      }
    attributes[fmt::format("JOINTS_{}", set)] = document_.addJoints(joints);
    attributes[fmt::format("WEIGHTS_{}", set)] = document_.addVectors(weights);
  }
}

// A mesh's primitives have the same number of targets; missing ones move nothing.
Json MeshWriter::targetsOf(const Deformation& deformation, size_t vertices, size_t count) {
  Json targets = Json::array();
  for (size_t i = 0; i < count; ++i) {
    Json target = Json::object();
    if (i < deformation.targets.size()) {
      const MorphTarget& source = deformation.targets[i];
      if (!source.positions.empty()) target["POSITION"] = document_.addPositions(source.positions);
      if (!source.normals.empty()) target["NORMAL"] = document_.addVectors(source.normals);
      if (!source.tangents.empty()) target["TANGENT"] = document_.addVectors(source.tangents);
    }
    if (target.empty()) target["POSITION"] = document_.addZeros(vertices);
    targets.push_back(std::move(target));
  }
  return targets;
}

const Mesh& MeshWriter::meshAt(uint32_t index) const {
  const Mesh& mesh = scene_.meshes[index];
  return mesh.morphable ? mesh.morphable->mesh : mesh;
}

// The weights of morph targets that no node sets; null if all are 0.
Json MeshWriter::restWeightsOf(const std::vector<Primitive>& primitives) const {
  Json weights;
  for (const Primitive& primitive : primitives) {
    const auto& morphable = scene_.meshes[primitive.mesh].morphable;
    if (!morphable || morphable->weights.size() <= weights.size()) continue;
    weights = Json::array();
    for (const float weight : morphable->weights) weights.push_back(shortest(weight));
  }
  return weights;
}

Json MeshWriter::geometryOf(const Primitive& source, size_t targets) {
  const auto [known, isNew] = geometry_.try_emplace({source.mesh, targets, source.omitsTangents});
  if (!isNew) return known->second;
  const Mesh& mesh = meshAt(source.mesh);
  const Deformation* deformation = mesh.deformation.get();
  Json attributes = attributesOf(mesh, source.omitsTangents);
  if (deformation && deformation->skin >= 0) addSkin(*deformation, attributes);
  std::vector<uint32_t> indices = mesh.indices;
  if (deformation && deformation->mirroredAtRest)  // loading has reversed the winding
    for (size_t i = 0; i + 2 < indices.size(); i += 3) std::swap(indices[i + 1], indices[i + 2]);
  Json primitive{{"attributes", std::move(attributes)}, {"indices", document_.addIndices(indices)}};
  if (deformation && targets > 0) primitive["targets"] = targetsOf(*deformation, mesh.positions.size(), targets);
  return known->second = std::move(primitive);
}

size_t MeshWriter::add(const std::string& name, const std::vector<Primitive>& primitives) {
  const auto [known, isNew] = known_.try_emplace({name, primitives}, 0);
  if (!isNew) return known->second;
  size_t targets = 0;
  for (const Primitive& primitive : primitives)
    if (const auto& deformation = meshAt(primitive.mesh).deformation)
      targets = std::max(targets, deformation->targets.size());
  Json list = Json::array();
  for (const Primitive& primitive : primitives) {
    Json out = geometryOf(primitive, targets);
    if (primitive.material >= 0) out["material"] = primitive.material;
    for (const auto& [variant, material] : primitive.variants)
      arrayIn(document_.extension(out, "KHR_materials_variants"), "mappings")
          .push_back({{"material", material}, {"variants", {variant}}});
    list.push_back(std::move(out));
  }
  Json mesh{{"primitives", std::move(list)}};
  if (Json weights = restWeightsOf(primitives); !weights.is_null()) {
    while (weights.size() < targets) weights.push_back(0);
    mesh["weights"] = std::move(weights);
  }
  if (!name.empty()) mesh["name"] = name;
  return known->second = document_.add("meshes", std::move(mesh));
}

}  // namespace latelight::exports
