// A kind of variation: what of a scene it changes, drawn anew for each number. A file each; variationKinds() lists
// them.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "data/random.h"
#include "data/spec.h"
#include "data/variations/oriented_box.h"
#include "scene/edit.h"

namespace latelight::data {

struct AddedObject {
  std::string name;
  std::vector<scene::ObjectPart> parts;
};

// What a variation is to make of the scene. Elements that no kind changes are in none of the lists.
struct Draft {
  const scene::Scene& scene;  // with the values that it had at first, but for what was added to it then
  std::map<uint32_t, scene::Material> materials;
  std::map<uint32_t, scene::Light> lights;
  std::map<uint32_t, scene::dmat4> transforms;  // of instances
  std::set<uint32_t> hidden;                   // instances
  std::vector<scene::Light> addedLights;
  std::vector<AddedObject> addedObjects;
  std::vector<OrientedBox> taken;  // by added objects
  std::string environment;
  std::optional<double> environmentRotation;  // degrees

  // As the kinds before left it.
  scene::Material& material(uint32_t index) {
    return materials.try_emplace(index, scene.materials[index]).first->second;
  }
  scene::Light& light(uint32_t index) { return lights.try_emplace(index, scene.lights[index]).first->second; }
  scene::dmat4& transform(uint32_t index) {
    return transforms.try_emplace(index, scene.instances[index].toWorld).first->second;
  }
};

// What a kind needs of its number: its own stream for each thing that it draws for.
struct Draw {
  uint64_t seed, number;
  Random of(std::string_view thing) const { return Random(seed, number, thing); }
};

class Variation {
 public:
  virtual ~Variation() = default;
  // Says what was drawn.
  virtual nlohmann::ordered_json draw(const Draw& draw, Draft& draft) const = 0;
};

struct VariationKind {
  std::string_view name, description;  // name: what "type" says
  // Asks for all keys that it takes. May add meshes, materials and textures to the scene.
  std::unique_ptr<Variation> (*make)(Spec& spec, scene::Scene& scene);
};
std::span<const VariationKind> variationKinds();

std::unique_ptr<Variation> varyMaterials(Spec& spec, scene::Scene& scene);
std::unique_ptr<Variation> varyTextures(Spec& spec, scene::Scene& scene);
std::unique_ptr<Variation> varyLights(Spec& spec, scene::Scene& scene);
std::unique_ptr<Variation> addLights(Spec& spec, scene::Scene& scene);
std::unique_ptr<Variation> varyEnvironments(Spec& spec, scene::Scene& scene);
std::unique_ptr<Variation> varyTransforms(Spec& spec, scene::Scene& scene);
std::unique_ptr<Variation> varyVisibility(Spec& spec, scene::Scene& scene);
std::unique_ptr<Variation> scatterObjects(Spec& spec, scene::Scene& scene);

}  // namespace latelight::data
