#include "scene/gltf_instances.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <unordered_set>

#include "base/error.h"
#include "base/hash.h"
#include "base/log.h"
#include "scene/gltf_accessor.h"
#include "scene/gltf_material.h"

namespace latelight::scene::gltf {
namespace {

// Ids are hashes of what they name, and unique: who comes later in the file gives way.
class Ids {
 public:
  uint32_t make(const std::string& name) {
    uint32_t id = hash32(name);
    for (unsigned attempt = 2; id == 0 || !used_.insert(id).second; ++attempt)
      id = hash32(fmt::format("{}~{}", name, attempt));
    return id;
  }

 private:
  std::unordered_set<uint32_t> used_;
};

// Primitives whose bytes are the same, in whichever mesh: exporters repeat a geometry for each material.
using Geometry = std::tuple<std::map<std::string, int>, std::vector<std::map<std::string, int>>, int, int, int>;

Geometry geometryOf(const tinygltf::Primitive& p) {
  const tinygltf::Value* draco = extension(p.extensions, "KHR_draco_mesh_compression");
  return {p.attributes, p.targets, p.indices, p.mode, draco ? indexOr(*draco, "bufferView", -1) : -1};
}

std::vector<double> weightsOf(const tinygltf::Node& node, const tinygltf::Mesh& mesh, const tinygltf::Primitive& p) {
  std::vector<double> weights = node.weights.empty() ? mesh.weights : node.weights;
  weights.resize(std::min(weights.size(), p.targets.size()));
  bool idle = std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0; });
  return idle ? std::vector<double>() : weights;
}

// Tangents are made for the texture that uses them: its UV set, turned by its transform.
std::optional<TangentSpace> tangentSpaceOf(const Material& material, const tinygltf::Primitive& p) {
  bool given = p.attributes.contains("TANGENT") && p.attributes.contains("NORMAL");
  if (given || !(material.data.textures & 1u << shared::kTextureNormal)) return std::nullopt;
  const shared::TextureTransform& t = material.data.transforms[shared::kTextureNormal];
  return TangentSpace{t.uvSet, vec2(t.row0), vec2(t.row1)};
}

// EXT_mesh_gpu_instancing: transforms below the node's own; one identity where the node has none.
std::vector<glm::dmat4> instanceTransforms(const Document& document, const tinygltf::Node& node, size_t index) {
  const tinygltf::Value* object = extension(node.extensions, "EXT_mesh_gpu_instancing");
  if (!object) return {glm::dmat4(1)};
  const tinygltf::Value& attributes = object->Get("attributes");
  std::optional<size_t> count;
  auto read = [&](const char* key, vec4 otherwise, bool normalized) {
    std::vector<vec4> values;
    int accessor = attributes.IsObject() ? indexOr(attributes, key, -1) : -1;
    if (accessor < 0) return values;
    Elements elements = resolve(document, accessor);
    elements.normalized |= normalized;
    if (count.value_or(elements.count) != elements.count)
      badInput("nodes[{}] has EXT_mesh_gpu_instancing attributes of different lengths", index);
    count = elements.count;
    document.budget.charge(elements.count * (sizeof(Instance) + sizeof(glm::dmat4) + 3 * sizeof(vec4)), elements.name);
    values = readFinite<4>(elements, 0, elements.count, otherwise.w);
    return values;
  };
  std::vector<vec4> translations = read("TRANSLATION", vec4(0), false);
  std::vector<vec4> rotations = read("ROTATION", vec4(0, 0, 0, 1), true);  // whole numbers are always fractions here
  std::vector<vec4> scales = read("SCALE", vec4(1), false);
  std::vector<glm::dmat4> transforms(count.value_or(0));
  for (size_t i = 0; i < transforms.size(); ++i)
    transforms[i] = composeTransform(translations.empty() ? glm::dvec3(0) : glm::dvec3(translations[i]),
                                     rotations.empty() ? glm::dvec4(0, 0, 0, 1) : glm::dvec4(rotations[i]),
                                     scales.empty() ? glm::dvec3(1) : glm::dvec3(scales[i]));
  if (transforms.empty()) warn("nodes[{}] has EXT_mesh_gpu_instancing without instances, and is not drawn", index);
  return transforms;
}

class Placer {
 public:
  Placer(const Document& document, const Hierarchy& hierarchy, int variant, Scene& scene)
      : document_(document), hierarchy_(hierarchy), variant_(variant), scene_(scene) {
    for (const Animation& animation : scene.rig.animations)
      for (const Track& track : animation.tracks)
        if (track.property == AnimatedProperty::Weights) moved_.insert(track.node);
  }

  std::vector<MeshRequest> run() {
    for (size_t i = 0; i < hierarchy_.order.size(); ++i) placeNode(i);
    if (!scene_.rig.offsets.empty()) scene_.rig.offsets.resize(scene_.instances.size(), glm::dmat4(1));
    return std::move(requests_);
  }

 private:
  void placeNode(size_t place) {
    size_t index = size_t(hierarchy_.order[place]);
    const tinygltf::Node& node = document_.model.nodes[index];
    if (node.mesh < 0) return;
    const tinygltf::Mesh& mesh = document_.model.meshes[size_t(node.mesh)];
    std::vector<glm::dmat4> transforms = instanceTransforms(document_, node, index);
    bool instanced = extension(node.extensions, "EXT_mesh_gpu_instancing");
    for (size_t p = 0; p < mesh.primitives.size(); ++p) {
      const tinygltf::Primitive& primitive = mesh.primitives[p];
      if (!isDrawn(primitive)) continue;
      uint32_t material = materialFor(primitive);
      MeshRequest request{.mesh = node.mesh,
                          .primitive = int(p),
                          .skin = primitive.attributes.contains("JOINTS_0") ? node.skin : -1,
                          .weights = weightsOf(node, mesh, primitive),
                          .weightsNode = primitive.targets.empty() ? -1 : movedWeights(int(index)),
                          .tangentSpace = tangentSpaceOf(scene_.materials[material], primitive)};
      // A skinned mesh is posed in the file's frame already: its own node does not move it.
      const bool posed = request.skin >= 0;
      glm::dmat4 world = posed ? glm::dmat4(1) : hierarchy_.world[index];
      Instance instance{.mesh = find(request, primitive), .material = material, .node = uint32_t(place)};
      instance.posed = posed;
      std::string name = scene_.nodes[place].path;
      if (mesh.primitives.size() > 1) name += fmt::format("/primitive{}", p);
      document_.budget.charge(transforms.size() * 2 * sizeof(Instance), name);
      for (size_t k = 0; k < transforms.size(); ++k) {
        instance.toWorld = toWorldFromGltf() * mat4(world * transforms[k]);
        instance.id = ids_.make(instanced ? fmt::format("{}/instance{}", name, k) : name);
        if (instanced) placeBelow(transforms[k]);
        scene_.instances.push_back(instance);
      }
    }
  }

  bool isDrawn(const tinygltf::Primitive& primitive) const {
    if (triangleCount(document_, primitive) > 0) return true;
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES)
      warn("points and lines are not drawn, only triangles");
    else
      warn("the file has primitives without a single triangle, which are left out");
    return false;
  }

  uint32_t materialFor(const tinygltf::Primitive& primitive) {
    int material = materialOf(primitive, variant_);
    if (material >= 0) return uint32_t(material);
    if (!default_) {
      default_ = uint32_t(scene_.materials.size());
      scene_.materials.push_back(defaultMaterial());
    }
    return *default_;
  }

  // Notes the transform of the instance to come below its node, where nodes may move.
  void placeBelow(const glm::dmat4& transform) {
    if (scene_.rig.empty()) return;
    scene_.rig.offsets.resize(scene_.instances.size(), glm::dmat4(1));
    scene_.rig.offsets.push_back(transform);
  }

  // The node itself if an animation moves its weights, else -1.
  int movedWeights(int node) const { return moved_.contains(uint32_t(node)) ? node : -1; }

  // The place of an equal request, or of this one appended.
  uint32_t find(const MeshRequest& request, const tinygltf::Primitive& primitive) {
    std::vector<uint32_t>& candidates = known_[geometryOf(primitive)];
    for (uint32_t candidate : candidates) {
      const MeshRequest& other = requests_[candidate];
      if (other.skin == request.skin && other.weights == request.weights && other.weightsNode == request.weightsNode &&
          other.tangentSpace == request.tangentSpace)
        return candidate;
    }
    candidates.push_back(uint32_t(requests_.size()));
    requests_.push_back(request);
    return candidates.back();
  }

  const Document& document_;
  const Hierarchy& hierarchy_;
  int variant_;
  Scene& scene_;
  std::vector<MeshRequest> requests_;
  std::map<Geometry, std::vector<uint32_t>> known_;
  std::optional<uint32_t> default_;
  std::unordered_set<uint32_t> moved_;  // nodes whose weights an animation moves
  Ids ids_;
};

}  // namespace

std::vector<MeshRequest> placeInstances(const Document& document, const Hierarchy& hierarchy, int variant,
                                        Scene& scene) {
  return Placer(document, hierarchy, variant, scene).run();
}

}  // namespace latelight::scene::gltf
