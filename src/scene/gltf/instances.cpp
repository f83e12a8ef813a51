// Creates the instances of the scene's nodes, and merges equal mesh requests.
#include "scene/gltf/instances.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <span>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "base/error.h"
#include "base/hash.h"
#include "base/log.h"
#include "base/parallel.h"
#include "scene/gltf/accessor.h"
#include "scene/gltf/accessor_types.h"
#include "scene/gltf/material.h"
#include "scene/gltf/skin.h"
#include "scene/ids.h"
#include "scene/tangents.h"

namespace latelight::scene::gltf {
namespace {

// A key that is equal for primitives with the same bytes, also across meshes, because exporters repeat a geometry for
// each material.
using Geometry = std::tuple<file::Attributes, std::vector<file::Attributes>, int, int, int, std::map<std::string, int>>;

Geometry geometryOf(const file::Primitive& p) {
  const file::DracoCompression draco = p.draco.value_or(file::DracoCompression());
  return {p.attributes, p.targets, p.indices, p.mode, draco.bufferView, draco.attributes};
}

std::vector<double> weightsOf(const file::Node& node, const file::Mesh& mesh, const file::Primitive& p) {
  std::vector<double> weights = node.weights.empty() ? mesh.weights : node.weights;
  weights.resize(std::min(weights.size(), p.targets.size()));
  bool idle = std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0; });
  return idle ? std::vector<double>() : weights;
}

// Tangents are generated for the texture that uses them: for its UV set, with its transform applied.
std::optional<TangentSpace> missingTangents(const Material& material, const file::Primitive& p,
                                            const LoadOptions& options) {
  const bool given = p.attributes.contains("TANGENT") && p.attributes.contains("NORMAL");
  return given ? std::nullopt : tangentSpaceOf(material, options);
}

bool usesSecondUv(const Material& material) {
  for (uint32_t slot = 0; slot < shared::kTextureCount; ++slot)
    if ((material.data.textures >> slot & 1u) != 0 && material.data.transforms[slot].uvSet == 1) return true;
  return false;
}

// EXT_mesh_gpu_instancing: the transforms of instances relative to their node. Without the extension there is a single
// instance at the node itself.
struct Placements {
  size_t count = 1;
  FileCopies copies;
};

// Returns the number of elements of every attribute, including those of applications, such as "_ID"; nullopt if there
// are no attributes.
std::optional<size_t> countOf(const Document& document, const file::Attributes& attributes, size_t node) {
  std::optional<size_t> count;
  for (const auto& [key, accessor] : attributes) {
    const size_t own = document.model.accessors[size_t(accessor)].count;
    if (count.value_or(own) != own)
      badInput("nodes[{}] has EXT_mesh_gpu_instancing attributes of different lengths", node);
    count = own;
  }
  return count;
}

Placements readPlacements(const Document& document, const file::Node& node, size_t index) {
  if (!node.instancing) return {};
  const std::optional<size_t> count = countOf(document, *node.instancing, index);
  auto read = [&](const char* key, vec4 otherwise, bool normalized) {
    std::vector<vec4> values;
    const auto accessor = node.instancing->find(key);
    if (accessor == node.instancing->end()) return values;
    Elements elements = resolve(document, accessor->second);
    checkType(elements, AccessorUse::Instances, key, fmt::format("nodes[{}].EXT_mesh_gpu_instancing.{}", index, key));
    elements.normalized |= normalized;
    document.budget.charge(elements.count * (sizeof(Instance) + 3 * sizeof(vec4)), elements.name);
    bool anyBroken = false;
    values = readRepaired<4>(elements, 0, elements.count, anyBroken, 0, otherwise.w);
    if (anyBroken) badInput("{} has values that are not finite numbers", elements.name);
    return values;
  };
  Placements placements;
  placements.copies.translations = read("TRANSLATION", vec4(0), false);
  placements.copies.rotations = read("ROTATION", vec4(0, 0, 0, 1), true);  // integers are always normalized here
  placements.copies.scales = read("SCALE", vec4(1), false);
  placements.count = count.value_or(0);
  if (placements.count == 0)
    warn("nodes[{}] has EXT_mesh_gpu_instancing without instances, and is not rendered", index);
  return placements;
}

class Placer {
 public:
  Placer(const Document& document, const Hierarchy& hierarchy, int variant, const LoadOptions& options, Scene& scene)
      : document_(document), hierarchy_(hierarchy), variant_(variant), options_(options), scene_(scene) {
    for (const Animation& animation : scene.rig.animations)
      for (const Track& track : animation.tracks)
        if (track.property == AnimatedProperty::Weights) moved_.insert(track.node);
  }

  std::vector<MeshRequest> run() {
    for (Node& node : scene_.nodes) node.id = ids_.make(node.path);
    for (size_t i = 0; i < hierarchy_.order.size(); ++i) placeNode(i);
    return std::move(requests_);
  }

 private:
  void placeNode(size_t place) {
    size_t index = size_t(hierarchy_.order[place]);
    const file::Node& node = document_.model.nodes[index];
    if (node.mesh < 0) return;
    scene_.nodes[place].mesh = meshName(document_, node.mesh);
    Placements placements = readPlacements(document_, node, index);
    const size_t first = scene_.instances.size();
    const size_t primitives = document_.model.meshes[size_t(node.mesh)].primitives.size();
    for (size_t p = 0; p < primitives; ++p) placePrimitive(place, p, placements);
    identify(scene_.nodes[place], primitives > 1, std::span(scene_.instances).subspan(first), placements.count);
    if (node.instancing) scene_.fileCopies.emplace(uint32_t(place), std::move(placements.copies));
  }

  void placePrimitive(size_t place, size_t p, const Placements& placements) {
    size_t index = size_t(hierarchy_.order[place]);
    const file::Node& node = document_.model.nodes[index];
    const file::Mesh& mesh = document_.model.meshes[size_t(node.mesh)];
    const file::Primitive& primitive = mesh.primitives[p];
    if (!isDrawn(primitive)) return;
    uint32_t material = materialFor(primitive);
    MeshRequest request{.mesh = node.mesh,
                        .primitive = int(p),
                        .skin = primitive.attributes.contains("JOINTS_0") ? node.skin : -1,
                        .weights = weightsOf(node, mesh, primitive),
                        .weightsNode = primitive.targets.empty() ? -1 : movedWeights(int(index)),
                        .tangentSpace = missingTangents(scene_.materials[material], primitive, options_),
                        .copiesUv = lacksSecondUv(primitive, material)};
    if (request.copiesUv && warned_.insert(material).second)
      warn("meshes[{}].primitives[{}] has no TEXCOORD_1, which the material \"{}\" uses: TEXCOORD_0 is used instead",
           node.mesh, p, scene_.materials[material].name);
    // A skinned mesh is already posed in the file's frame, so its own node does not move it.
    const bool posed = request.skin >= 0;
    const glm::dmat4 world = posed ? glm::dmat4(1) : hierarchy_.world[index];
    const glm::dvec3 origin = posed ? skinOrigin(document_, hierarchy_, request.skin) : glm::dvec3(0);
    Instance instance{.mesh = find(request, primitive), .material = material, .node = uint32_t(place)};
    instance.primitive = uint32_t(p);
    instance.posed = posed;
    instance.hidden = hierarchy_.hidden[index];
    document_.budget.charge(placements.count * 2 * sizeof(Instance), scene_.nodes[place].path);
    const bool instanced = node.instancing.has_value();
    const size_t first = scene_.instances.size();
    scene_.instances.resize(first + placements.count, instance);
    addVariants(primitive, first);
    parallelFor(placements.count, 4096, [&](size_t begin, size_t end) {
      for (size_t k = begin; k < end; ++k) {
        const glm::dmat4 below = instanced ? nodeFromCopy(placements.copies, k) : glm::dmat4(1);
        scene_.instances[first + k].toWorld = toWorldFromGltf() * glm::translate(world * below, origin);
        if (instanced) scene_.instances[first + k].copy = int(k);
      }
    });
  }

  // Records the materials of the instances from `first` on in the variants that the primitive lists.
  void addVariants(const file::Primitive& primitive, size_t first) {
    for (const file::VariantMapping& mapping : primitive.variants)
      for (const int variant : mapping.variants) {
        const size_t count = scene_.instances.size() - first;
        document_.budget.charge(count * 2 * sizeof(VariantMaterial), "its variants");
        for (size_t i = first; i < first + count; ++i)
          scene_.variantMaterials.push_back({uint32_t(variant), uint32_t(i), uint32_t(mapping.material)});
      }
  }

  // Assigns the ids of a node's instances: primitive by primitive, with all copies of each.
  void identify(const Node& node, bool several, std::span<Instance> instances, size_t copies) {
    const auto nameOf = [&](const Instance& instance, bool part) {
      std::string name = node.path;
      if (instance.copy >= 0) name += fmt::format("/instance{}", instance.copy);
      if (part && several) name += fmt::format("/primitive{}", instance.primitive);
      return name;
    };
    parallelFor(instances.size(), 4096, [&](size_t begin, size_t end) {
      for (Instance& instance : instances.subspan(begin, end - begin)) {
        instance.id = hash32(nameOf(instance, false));
        instance.part = hash32(nameOf(instance, true));
      }
    });
    for (size_t i = 0; i < instances.size(); ++i) {
      Instance& instance = instances[i];
      instance.part = parts_.make(instance.part, [&] { return nameOf(instance, true); });
      if (instance.copy < 0)
        instance.id = node.id;
      else if (i >= copies)
        instance.id = instances[i - copies].id;
      else
        instance.id = ids_.make(instance.id, [&] { return nameOf(instance, false); });
    }
  }

  bool isDrawn(const file::Primitive& primitive) const {
    if (triangleCount(document_, primitive) > 0) return true;
    if (primitive.mode < file::kTriangles)
      warn("points and lines are not supported and are skipped");
    else
      warn("the file has primitives without triangles, which are skipped");
    return false;
  }

  uint32_t materialFor(const file::Primitive& primitive) {
    int material = materialOf(primitive, variant_);
    if (material >= 0) return uint32_t(material);
    if (!default_) {
      default_ = uint32_t(scene_.materials.size());
      scene_.materials.push_back(defaultMaterial());
    }
    return *default_;
  }

  // Returns true if a texture has coordinates that only the first set of the primitive can replace.
  bool lacksSecondUv(const file::Primitive& primitive, uint32_t material) const {
    const file::Attributes& attributes = primitive.attributes;
    return !attributes.contains("TEXCOORD_1") && attributes.contains("TEXCOORD_0") &&
           usesSecondUv(scene_.materials[material]);
  }

  // Returns the node itself if an animation changes its weights, otherwise -1.
  int movedWeights(int node) const { return moved_.contains(uint32_t(node)) ? node : -1; }

  // Returns the index of an equal request, or appends this one and returns its index.
  uint32_t find(const MeshRequest& request, const file::Primitive& primitive) {
    std::vector<uint32_t>& candidates = known_[geometryOf(primitive)];
    for (uint32_t candidate : candidates) {
      const MeshRequest& other = requests_[candidate];
      if (other.skin == request.skin && other.weights == request.weights && other.weightsNode == request.weightsNode &&
          other.tangentSpace == request.tangentSpace && other.copiesUv == request.copiesUv)
        return candidate;
    }
    candidates.push_back(uint32_t(requests_.size()));
    requests_.push_back(request);
    return candidates.back();
  }

  const Document& document_;
  const Hierarchy& hierarchy_;
  int variant_;
  const LoadOptions& options_;
  Scene& scene_;
  std::vector<MeshRequest> requests_;
  std::map<Geometry, std::vector<uint32_t>> known_;
  std::optional<uint32_t> default_;
  std::unordered_set<uint32_t> moved_;   // nodes whose weights are animated
  std::unordered_set<uint32_t> warned_;  // materials without their second set of texture coordinates
  UniqueIds ids_, parts_;                // ids of nodes and copies, and of instances
};

}  // namespace

std::vector<MeshRequest> placeInstances(const Document& document, const Hierarchy& hierarchy, int variant,
                                        const LoadOptions& options, Scene& scene) {
  return Placer(document, hierarchy, variant, options, scene).run();
}

}  // namespace latelight::scene::gltf
