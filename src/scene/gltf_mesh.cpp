#include "scene/gltf_mesh.h"

#include <cmath>
#include <numeric>

#include "base/error.h"
#include "scene/gltf_vertices.h"

namespace latelight::scene::gltf {
namespace {

// The memory of one vertex during loading, streams and result together.
constexpr size_t kVertexBytes = 2 * (sizeof(vec3) + sizeof(shared::VertexAttributes) + sizeof(shared::VertexExtra));

const Elements* find(const Source& source, const char* key) {
  auto found = source.attributes.find(key);
  return found == source.attributes.end() ? nullptr : &found->second;
}

// Colours are normalised whether or not the accessor says so: integers up to 65535 are not valid colours.
std::vector<vec4> readColors(Elements elements, const Source& source) {
  elements.normalized = true;
  return readFinite<4>(elements, source.first, source.count, 1.0f);
}

Vertices readVertices(const Source& source) {
  Vertices v;
  v.positions = readFinite<3>(*find(source, "POSITION"), source.first, source.count);
  if (const Elements* e = find(source, "NORMAL")) {
    v.normals.resize(source.count);
    readVectors<3>(*e, source.first, source.count, v.normals.data());  // invalid ones are repaired later
  }
  if (const Elements* e = find(source, "TANGENT"); e && !v.normals.empty()) {
    v.tangents.resize(source.count);
    readVectors<4>(*e, source.first, source.count, v.tangents.data());
  }
  if (const Elements* e = find(source, "TEXCOORD_0")) v.uv[0] = readFinite<2>(*e, source.first, source.count);
  if (const Elements* e = find(source, "TEXCOORD_1")) v.uv[1] = readFinite<2>(*e, source.first, source.count);
  if (const Elements* e = find(source, "COLOR_0")) v.colors = readColors(*e, source);
  v.origin.resize(source.count);
  std::iota(v.origin.begin(), v.origin.end(), 0u);
  return v;
}

void requireFinite(const std::vector<vec3>& positions, const std::string& name) {
  for (const vec3& p : positions)
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
      badInput("{} has positions that are not finite once posed", name);
}

void makeTangents(const TangentSpace& space, Vertices& v, std::vector<uint32_t>& indices) {
  std::vector<vec2> uv = v.uv[space.uvSet];
  if (uv.empty()) return;
  for (vec2& t : uv) t = vec2(glm::dot(space.row0, t), glm::dot(space.row1, t));
  scene::makeTangents(uv, v, indices);
}

// The mesh's deformation; null where it has neither a skin nor animated weights.
std::shared_ptr<Deformation> readDeformation(const Document& document, const MeshRequest& request, const Source& source,
                                             const std::vector<uint32_t>& origin, const Mesh& mesh) {
  auto deformation = std::make_shared<Deformation>();
  if (request.skin >= 0) readSkinWeights(document, request.skin, source, origin, *deformation);
  if (request.weightsNode >= 0) {
    const tinygltf::Mesh& parent = document.model.meshes[size_t(request.mesh)];
    deformation->weightsNode = request.weightsNode;
    readMorphTargets(document, parent.primitives[size_t(request.primitive)], source, origin, *deformation);
  }
  if (deformation->skin < 0 && deformation->weightsNode < 0) return nullptr;
  deformation->positions = mesh.positions;
  deformation->attributes = mesh.attributes;
  return deformation;
}

// The mesh with its joints and weights at rest. Joints that mirror it turn its triangles over, so that their front faces
// are counter-clockwise again.
void poseAtRest(const Document& document, const Hierarchy& hierarchy, const MeshRequest& request,
                Deformation& deformation, Mesh& mesh) {
  std::vector<mat4> joints;
  if (deformation.skin >= 0) {
    joints = restJoints(document, hierarchy, deformation.skin);
    deformation.mirroredAtRest = isMirrored(reachOf(deformation), joints);
  }
  if (deformation.mirroredAtRest)
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  const std::vector<float> weights(request.weights.begin(), request.weights.end());
  DeformedVertices posed = deform(deformation, joints, weights);
  mesh.positions = std::move(posed.positions);
  mesh.attributes = std::move(posed.attributes);
}

}  // namespace

std::string meshName(const Document& document, int mesh) {
  const std::string& name = document.model.meshes[size_t(mesh)].name;
  return name.empty() ? fmt::format("mesh{}", mesh) : name;
}

Mesh buildMesh(const Document& document, const Hierarchy& hierarchy, const MeshRequest& request) {
  const tinygltf::Mesh& parent = document.model.meshes[size_t(request.mesh)];
  const tinygltf::Primitive& primitive = parent.primitives[size_t(request.primitive)];
  Source source =
      readSource(document, primitive, fmt::format("meshes[{}].primitives[{}]", request.mesh, request.primitive));
  document.budget.charge(source.count * kVertexBytes, source.name);
  Vertices vertices = readVertices(source);
  applyMorphTargets(document, primitive, source, request.weights, request.weightsNode < 0, vertices);

  std::vector<uint32_t> indices = std::move(source.indices);
  const bool flat = vertices.normals.empty();
  if (flat) {
    document.budget.charge(indices.size() * kVertexBytes, source.name);
    makeFlatNormals(vertices, indices);
  } else {
    repairNormals(vertices, indices);
  }
  repairTangents(vertices.tangents);
  if (vertices.tangents.empty() && request.tangentSpace) makeTangents(*request.tangentSpace, vertices, indices);

  const std::vector<uint32_t> origin = std::move(vertices.origin);
  Mesh mesh = pack(std::move(vertices), std::move(indices));
  if (auto deformation = readDeformation(document, request, source, origin, mesh)) {
    deformation->flatNormals = flat && origin.size() == mesh.indices.size();  // not where tangents split vertices
    poseAtRest(document, hierarchy, request, *deformation, mesh);
    if (!document.animations.empty()) mesh.deformation = std::move(deformation);
  }
  requireFinite(mesh.positions, source.name);
  findBounds(mesh);
  mesh.name = meshName(document, request.mesh);
  if (parent.primitives.size() > 1) mesh.name += fmt::format("/primitive{}", request.primitive);
  return mesh;
}

}  // namespace latelight::scene::gltf
