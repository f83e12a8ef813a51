// Computes the bounds of scenes, their coats, and the transforms of cameras and lights.
#include "scene/scene.h"

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "shared/light.h"

namespace latelight::scene {
namespace {

// Returns a rigid frame from a transform that may scale: camera space is in the file's meters, regardless of its node's
// scale.
dmat4 rigid(const dmat4& m, bool& degenerate) {
  using glm::dvec4;
  dvec3 x = m[0], y = m[1], z = m[2];
  degenerate = glm::length(z) == 0 || glm::length(glm::cross(y, z)) == 0;
  if (degenerate) return dmat4(dvec4(1, 0, 0, 0), dvec4(0, 1, 0, 0), dvec4(0, 0, 1, 0), m[3]);
  z = glm::normalize(z);
  x = glm::normalize(glm::cross(y, z));
  y = glm::cross(z, x);
  return dmat4(dvec4(x, 0), dvec4(y, 0), dvec4(z, 0), m[3]);
}

}  // namespace

shared::MaterialLayers noLayers() {
  return {.clearcoatNormalScale = 1,
          .iridescenceIor = 1.3f,
          .iridescenceThinnest = 100,
          .iridescenceThickest = 400,
          .attenuationColor = vec3(1),
          .diffuseTransmissionColor = vec3(1)};
}

uint32_t layersOf(const shared::Material& material) {
  using namespace shared;
  const MaterialLayers& l = material.layers;
  if (material.flags & kMaterialUnlit) return 0;
  uint32_t layers = 0;
  if (l.clearcoat > 0) layers |= kLayerClearcoat;
  if (l.sheenColor != vec3(0)) layers |= kLayerSheen;
  if (l.anisotropy > 0) layers |= kLayerAnisotropy;
  if (l.iridescence > 0) layers |= kLayerIridescence;
  if (l.transmission > 0) layers |= kLayerTransmission;
  if (l.diffuseTransmission > 0) layers |= kLayerDiffuseTransmission;
  const bool passesLight = l.transmission > 0 || l.diffuseTransmission > 0;
  if (passesLight && l.thickness > 0) layers |= kLayerVolume;
  if (l.transmission > 0 && l.thickness > 0 && l.dispersion > 0) layers |= kLayerDispersion;
  return layers;
}

uint32_t layerFlags(const shared::Material& material) {
  const uint32_t layers = layersOf(material);
  if (layers & shared::kLayerTransmission) return shared::kMaterialLayered | shared::kMaterialTransmissive;
  return layers ? shared::kMaterialLayered : 0;
}

size_t Texture::bytes() const {
  size_t texels = 0;
  for (uint32_t level = 0; level < levels; ++level)
    texels += size_t{std::max(1u, width >> level)} * std::max(1u, height >> level);
  return texels * 4;
}

uint64_t Scene::triangleCount() const {
  uint64_t count = 0;
  for (const Instance& instance : instances)
    if (!instance.removed) count += meshes[instance.mesh].indices.size() / 3;
  return count;
}

uint64_t Mesh::bytes() const {
  const uint64_t vertex = sizeof(vec3) + sizeof(shared::VertexAttributes);
  return positions.size() * (deformation ? 2 : 1) * vertex + extras.size() * sizeof(shared::VertexExtra) +
         indices.size() * sizeof(uint32_t) + (morphable ? morphable->mesh.bytes() : 0);
}

namespace {

// Runs body(block, begin, end) on all threads for blocks of [0, count) that do not depend on the number of threads, so
// that results combined in the order of the blocks do not either.
constexpr size_t kBlock = size_t{1} << 16;
template <typename Body>
void forEachBlock(size_t count, Body body) {
  parallelFor((count + kBlock - 1) / kBlock, 1, [&](size_t first, size_t last) {
    for (size_t block = first; block < last; ++block)
      body(block, block * kBlock, std::min((block + 1) * kBlock, count));
  });
}

}  // namespace

void findBounds(Mesh& mesh) {
  const size_t vertices = mesh.positions.size(), triangles = mesh.indices.size() / 3;
  mesh.boundsMin = mesh.boundsMax = vertices == 0 ? vec3(0) : mesh.positions.front();
  std::vector<std::pair<vec3, vec3>> boxes((vertices + kBlock - 1) / kBlock, {mesh.boundsMin, mesh.boundsMax});
  forEachBlock(vertices, [&](size_t block, size_t begin, size_t end) {
    auto [low, high] = boxes[block];
    for (size_t i = begin; i < end; ++i)
      low = glm::min(low, mesh.positions[i]), high = glm::max(high, mesh.positions[i]);
    boxes[block] = {low, high};
  });
  for (const auto& [low, high] : boxes)
    mesh.boundsMin = glm::min(mesh.boundsMin, low), mesh.boundsMax = glm::max(mesh.boundsMax, high);
  std::vector<float> squares((triangles + kBlock - 1) / kBlock);
  forEachBlock(triangles, [&](size_t block, size_t begin, size_t end) {
    float squared = 0;
    for (size_t i = 3 * begin; i < 3 * end; i += 3) {
      const vec3 &a = mesh.positions[mesh.indices[i]], &b = mesh.positions[mesh.indices[i + 1]],
                 &c = mesh.positions[mesh.indices[i + 2]];
      for (const vec3& edge : {b - a, c - b, a - c}) squared = std::max(squared, glm::dot(edge, edge));
    }
    squares[block] = squared;
  });
  mesh.longestEdge = std::sqrt(squares.empty() ? 0 : std::ranges::max(squares));
}

// The origin lies within a factor of two of every vertex, so that the differences are exact (Sterbenz 1974,
// Floating-Point Computation, theorem 4.3.1).
vec3 vertexOrigin(const Mesh& mesh) {
  constexpr float kFar = 1024;  // meters in object space; floats are precise enough below
  vec3 origin(0);
  if (mesh.deformation) return origin;
  for (int i = 0; i < 3; ++i) {
    const float low = mesh.boundsMin[i], high = mesh.boundsMax[i], middle = 0.5f * low + 0.5f * high;
    if (std::abs(middle) >= kFar && high - low <= 0.25f * std::abs(middle)) origin[i] = middle;
  }
  return origin;
}

void addBounds(const Scene& scene, const Instance& instance, const dmat4& toWorld, Bounds& bounds) {
  const Mesh& mesh = scene.meshes[instance.mesh];
  if (!mesh.positions.empty()) addBox(mesh.boundsMin, mesh.boundsMax, toWorld, bounds);
}

void addBox(vec3 low, vec3 high, const dmat4& toWorld, Bounds& bounds) {
  for (int corner = 0; corner < 8; ++corner) {
    const vec3 p(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z);
    const dvec3 world = toWorld * glm::dvec4(p, 1.0);
    bounds.min = glm::min(bounds.min, world);
    bounds.max = glm::max(bounds.max, world);
  }
}

Bounds worldBounds(const Scene& scene) {
  Bounds all;
  std::mutex mutex;
  parallelFor(scene.instances.size(), 16384, [&](size_t begin, size_t end) {
    Bounds some;
    for (size_t i = begin; i < end; ++i)
      if (isShown(scene, {}, scene.instances[i]))
        addBounds(scene, scene.instances[i], scene.instances[i].toWorld, some);
    std::lock_guard lock(mutex);
    all.min = glm::min(all.min, some.min);
    all.max = glm::max(all.max, some.max);
  });
  return all;
}

double lowestPoint(const Scene& scene) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Instance& instance : scene.instances) {
    if (!isShown(scene, {}, instance)) continue;
    const dmat4 up = glm::transpose(instance.toWorld);  // its third column is the row of heights
    for (const auto& position : scene.meshes[instance.mesh].positions)
      lowest = std::min(lowest, glm::dot(up[2], glm::dvec4(dvec3(position), 1)));
  }
  return std::isfinite(lowest) ? lowest : 0;
}

dmat4 toWorldFromGltf() {
  // Columns: the world directions of glTF's X (right), Y (up) and Z (towards the viewer).
  using glm::dvec4;
  return dmat4(dvec4(1, 0, 0, 0), dvec4(0, 0, 1, 0), dvec4(0, -1, 0, 0), dvec4(0, 0, 0, 1));
}

dmat4 toGltfFromWorld() {
  return glm::transpose(toWorldFromGltf());
}

bool placeCamera(Camera& camera, const glm::dmat4& world) {
  bool degenerate = false;
  // The axes of camera space change in the same way as the world's.
  camera.toWorld = toWorldFromGltf() * rigid(world, degenerate) * toGltfFromWorld();
  return !degenerate;
}

void placeLight(Light& light, const glm::dmat4& world) {
  const dmat4 toWorld = toWorldFromGltf() * world;
  light.position = dvec3(toWorld[3]);
  const vec3 direction = -vec3(toWorld[2]);
  const float length = glm::length(direction);
  light.direction = length > 0 ? direction / length : vec3(toWorldFromGltf() * glm::dvec4(0, 0, -1, 0));
  if (shared::lightIsArea(light.type)) light.axes = mat3(toWorld);
}

RigNode statedTransform(const FileCopies& copies, size_t copy) {
  RigNode node;
  if (!copies.translations.empty()) node.translation = copies.translations[copy];
  if (!copies.rotations.empty()) node.rotation = copies.rotations[copy];
  if (!copies.scales.empty()) node.scale = copies.scales[copy];
  return node;
}

dmat4 nodeFromCopy(const FileCopies& copies, size_t copy) {
  const RigNode node = statedTransform(copies, copy);
  return composeTransform(node.translation, node.rotation, node.scale);
}

}  // namespace latelight::scene
