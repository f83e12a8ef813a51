// Builds a scene::Mesh from a primitive: reads, repairs, deforms and packs its vertices.
#include "scene/gltf/mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/vertices.h"

namespace latelight::scene::gltf {
namespace {

// The memory per vertex during loading, for streams and result together.
constexpr size_t kVertexBytes = 2 * (sizeof(vec3) + sizeof(shared::VertexAttributes) + sizeof(shared::VertexExtra));

// Returns the attribute, or null if it is absent. Throws Error(BadInput) if its type does not fit.
const Elements* findAttribute(const Source& source, const char* key) {
  auto found = source.attributes.find(key);
  if (found == source.attributes.end()) return nullptr;
  checkType(found->second, AccessorUse::Vertices, key, fmt::format("{}.{}", source.name, key));
  return &found->second;
}

// Colors are normalized regardless of the accessor's flag: integers up to 65535 are not valid colors.
std::vector<vec4> readColors(const Document& document, const Source& source, Elements elements) {
  elements.normalized = true;
  std::vector<vec4> colors = readAttribute<4>(document, source, "COLOR_0", elements, 1.0f, 1.0f);
  for (vec4& color : colors) color = glm::clamp(color, vec4(0), vec4(1));  // glTF 2.0, 3.7.2.1
  return colors;
}

bool isFinite(const vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// Reads positions, and drops triangles with a corner whose position is not finite. Such vertices get the position of
// another vertex, so that bounds stay valid.
std::vector<vec3> readPositions(const Document& document, Source& source) {
  std::vector<vec3> positions(source.count);
  readVectors<3>(*findAttribute(source, "POSITION"), source.first, source.count, positions.data());
  if (std::ranges::all_of(positions, isFinite)) return positions;
  document.repairs.add(source.name + ".POSITION");
  size_t kept = 0;
  for (size_t i = 0; i + 2 < source.indices.size(); i += 3) {
    const auto corner = source.indices.begin() + static_cast<ptrdiff_t>(i);
    if (std::all_of(corner, corner + 3, [&](uint32_t vertex) { return isFinite(positions[vertex]); })) {
      std::copy_n(corner, 3, source.indices.begin() + static_cast<ptrdiff_t>(kept));
      kept += 3;
    }
  }
  if (kept == 0) badInput("{} has no triangle whose positions are finite numbers", source.name);
  source.indices.resize(kept);
  for (vec3& p : positions)
    if (!isFinite(p)) p = positions[source.indices[0]];
  return positions;
}

Vertices readVertices(const Document& document, Source& source) {
  Vertices v;
  v.positions = readPositions(document, source);
  if (const Elements* e = findAttribute(source, "NORMAL")) v.normals = readAttribute<3>(document, source, "NORMAL", *e);
  if (const Elements* e = findAttribute(source, "TANGENT"); e && !v.normals.empty())
    v.tangents = readAttribute<4>(document, source, "TANGENT", *e);
  for (const auto& [key, set] : {std::pair("TEXCOORD_0", 0), {"TEXCOORD_1", 1}})
    if (const Elements* e = findAttribute(source, key)) v.uv[set] = readAttribute<2>(document, source, key, *e);
  if (const Elements* e = findAttribute(source, "COLOR_0")) v.colors = readColors(document, source, *e);
  v.origin.resize(source.count);
  std::iota(v.origin.begin(), v.origin.end(), 0u);
  return v;
}

void requireFinite(const std::vector<vec3>& positions, const std::string& name) {
  if (!std::ranges::all_of(positions, isFinite)) badInput("{} has positions that are not finite once posed", name);
}

MorphTarget readTarget(const Document& document, const file::Primitive& primitive, size_t index, const Source& source,
                       const VertexSources& vertexSources) {
  MorphTarget target = readMorphTarget(document, primitive, index, source, vertexSources.origin);
  for (size_t i = 0; i < target.normals.size() && !vertexSources.turned.empty(); ++i)
    if (vertexSources.turned[vertexSources.origin[i]]) target.normals[i] = -target.normals[i];
  return target;
}

// Moves the vertices by weights that no animation changes. The result is that of an animation with these weights, so
// generated tangents are those of the undeformed mesh.
void applyRestWeights(const Document& document, const MeshRequest& request, const file::Primitive& primitive,
                      const Source& source, const VertexSources& vertexSources, Mesh& mesh) {
  if (request.weightsNode >= 0 || request.weights.empty()) return;
  Deformation deformation{.flatNormals = vertexSources.flatNormals,
                          .positions = std::move(mesh.positions),
                          .attributes = std::move(mesh.attributes)};
  for (size_t t = 0; t < request.weights.size(); ++t)
    deformation.targets.push_back(request.weights[t] == 0 ? MorphTarget()
                                                          : readTarget(document, primitive, t, source, vertexSources));
  const std::vector<float> weights(request.weights.begin(), request.weights.end());
  DeformedVertices posed = deform(deformation, {}, weights);
  mesh.positions = std::move(posed.positions);
  mesh.attributes = std::move(posed.attributes);
  mesh.tangentSpace.reset();
}

// Returns the mesh's deformation, or null if it has neither a skin nor animated weights.
std::shared_ptr<Deformation> readDeformation(const Document& document, const MeshRequest& request,
                                             const file::Primitive& primitive, const Source& source,
                                             const VertexSources& vertexSources, const Mesh& mesh) {
  auto deformation = std::make_shared<Deformation>();
  if (request.skin >= 0) readSkinWeights(document, request.skin, source, vertexSources.origin, *deformation);
  if (request.weightsNode >= 0) {
    deformation->weightsNode = request.weightsNode;
    for (size_t t = 0; t < primitive.targets.size(); ++t)
      deformation->targets.push_back(readTarget(document, primitive, t, source, vertexSources));
  }
  if (deformation->skin < 0 && deformation->weightsNode < 0) return nullptr;
  deformation->flatNormals = vertexSources.flatNormals;
  deformation->positions = mesh.positions;
  deformation->attributes = mesh.attributes;
  return deformation;
}

// Poses the mesh with its joints and weights at rest. If the joints mirror it, its triangles' winding is reversed, so
// that front faces are counter-clockwise again.
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

size_t targetCount(const file::Mesh& mesh) {
  size_t count = 0;
  for (const file::Primitive& primitive : mesh.primitives) count = std::max(count, primitive.targets.size());
  return count;
}

std::string meshName(const Document& document, int mesh) {
  const std::string& name = document.model.meshes[size_t(mesh)].name;
  return name.empty() ? fmt::format("mesh{}", mesh) : name;
}

Mesh buildMesh(const Document& document, const Hierarchy& hierarchy, const MeshRequest& request) {
  const file::Mesh& parent = document.model.meshes[size_t(request.mesh)];
  const file::Primitive& primitive = parent.primitives[size_t(request.primitive)];
  Source source =
      readSource(document, primitive, fmt::format("meshes[{}].primitives[{}]", request.mesh, request.primitive));
  document.budget.charge(source.count * kVertexBytes, source.name);
  Vertices vertices = readVertices(document, source);
  morphCoordinatesAndColors(document, primitive, source, request.weights, vertices);
  if (request.copiesUv) vertices.uv[1] = vertices.uv[0];

  std::vector<uint32_t> indices = std::move(source.indices);
  const bool flat = vertices.normals.empty();
  VertexSources vertexSources;
  if (flat) {
    document.budget.charge(indices.size() * kVertexBytes, source.name);
    makeFlatNormals(vertices, indices);
  } else {
    vertexSources.turned = repairNormals(vertices, indices);
    if (!vertexSources.turned.empty())
      warn("{} has normals that point into its surface, which are turned over", source.name);
  }
  repairTangents(vertices.tangents);
  const bool generates = vertices.tangents.empty() && request.tangentSpace;
  if (generates) makeTangents(*request.tangentSpace, vertices, indices);

  vertexSources.origin = std::move(vertices.origin);
  vertexSources.flatNormals =
      flat && vertexSources.origin.size() == indices.size();  // false if tangents split vertices
  Mesh mesh = pack(std::move(vertices), std::move(indices));
  if (generates) mesh.tangentSpace = request.tangentSpace;
  applyRestWeights(document, request, primitive, source, vertexSources, mesh);
  if (auto deformation = readDeformation(document, request, primitive, source, vertexSources, mesh)) {
    poseAtRest(document, hierarchy, request, *deformation, mesh);
    mesh.deformation = std::move(deformation);
  }
  requireFinite(mesh.positions, source.name);
  findBounds(mesh);
  mesh.name = meshName(document, request.mesh);
  if (parent.primitives.size() > 1) mesh.name += fmt::format("/primitive{}", request.primitive);
  return mesh;
}

void addMorphable(const Document& document, const Hierarchy& hierarchy, MeshRequest request, Mesh& mesh) {
  const file::Mesh& parent = document.model.meshes[size_t(request.mesh)];
  if (request.weightsNode >= 0 || parent.primitives[size_t(request.primitive)].targets.empty()) return;
  request.weightsNode = 0;  // any: the edit that animates the weights sets the node
  auto morphable = std::make_shared<MorphableMesh>();
  morphable->mesh = buildMesh(document, hierarchy, request);
  morphable->weights.assign(request.weights.begin(), request.weights.end());
  mesh.morphable = std::move(morphable);
}

}  // namespace latelight::scene::gltf
