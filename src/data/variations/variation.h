// The interface of variations (domain randomization). A kind of variation changes one aspect of a scene, with new
// random values for each variation number. Each kind is one file; variationKinds() lists them.
#pragma once

#include <filesystem>
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
  std::optional<scene::NodeCopy> copy;  // empty: the parts are those of a file
};

// The changes of the scene that one variation number requires. Elements that no kind changes are in none of the lists.
struct Draft {
  const scene::Scene& scene;  // in its initial state, plus the meshes, materials and textures that kinds have added
  std::map<uint32_t, scene::Material> materials;
  std::map<uint32_t, scene::Light> lights;
  std::map<uint32_t, scene::dmat4> transforms;  // by instance
  std::map<uint32_t, scene::dmat4> movedNodes;  // transforms in the world, by node
  std::set<uint32_t> hiddenNodes;               // with all nodes below them
  std::vector<scene::Light> addedLights;
  std::vector<AddedObject> addedObjects;
  std::vector<OrientedBox> taken;  // boxes of added objects, in the world
  std::string environment;
  std::optional<double> environmentRotation;  // in degrees

  // Return an element for changes, with the changes of all previous kinds.
  scene::Material& material(uint32_t index) {
    return materials.try_emplace(index, scene.materials[index]).first->second;
  }
  scene::Light& light(uint32_t index) { return lights.try_emplace(index, scene.lights[index]).first->second; }
  scene::dmat4& transform(uint32_t index) {
    return transforms.try_emplace(index, scene.instances[index].toWorld).first->second;
  }
  scene::dmat4& nodeToWorld(uint32_t index) {
    return movedNodes.try_emplace(index, scene.nodes[index].toWorld).first->second;
  }
};

// The random numbers of one variation: a separate stream for each named quantity.
struct Draw {
  uint64_t seed, number;
  Random of(std::string_view thing) const { return Random(seed, number, thing); }
};

class Variation {
 public:
  virtual ~Variation() = default;
  // Adds random changes to the draft, and returns the drawn values for the manifest.
  virtual nlohmann::ordered_json draw(const Draw& draw, Draft& draft) const = 0;
  // Returns all objects that draw() may add, whichever numbers are drawn. If an object may consist of different parts,
  // the list has at least one object with each choice of parts.
  virtual std::vector<AddedObject> possibleObjects() const { return {}; }
  // Returns the environments from which draw() chooses; empty if it chooses none.
  virtual std::vector<std::string> possibleEnvironments() const { return {}; }
};

// The inputs of all kinds.
struct VariationContext {
  scene::Scene& scene;             // kinds may add meshes, materials and textures
  const scene::LoadOptions& load;  // options for files with further scenes
};

struct VariationKind {
  std::string_view name, description;  // name: the value of "type"
  // Creates a variation. It reads every key that the kind accepts, so that all other keys can be rejected.
  std::unique_ptr<Variation> (*make)(Spec& spec, const VariationContext& context);
  // Returns the files that a variation of this value of the job reads, in an order that depends only on the value and
  // the files' names. Values that `make` would reject have no files. Null: the kind reads none.
  std::vector<std::filesystem::path> (*files)(const nlohmann::ordered_json& value,
                                              const scene::LoadOptions& load) = nullptr;
};
std::span<const VariationKind> variationKinds();

std::unique_ptr<Variation> varyMaterials(Spec& spec, const VariationContext& context);
std::unique_ptr<Variation> varyTextures(Spec& spec, const VariationContext& context);
std::unique_ptr<Variation> varyLights(Spec& spec, const VariationContext& context);
std::unique_ptr<Variation> addLights(Spec& spec, const VariationContext& context);
std::unique_ptr<Variation> varyEnvironments(Spec& spec, const VariationContext& context);
std::unique_ptr<Variation> varyTransforms(Spec& spec, const VariationContext& context);
std::unique_ptr<Variation> varyVisibility(Spec& spec, const VariationContext& context);
std::unique_ptr<Variation> scatterObjects(Spec& spec, const VariationContext& context);

std::vector<std::filesystem::path> texturesFiles(const nlohmann::ordered_json& value, const scene::LoadOptions& load);
std::vector<std::filesystem::path> environmentsFiles(const nlohmann::ordered_json& value,
                                                     const scene::LoadOptions& load);
std::vector<std::filesystem::path> scatterFiles(const nlohmann::ordered_json& value, const scene::LoadOptions& load);

}  // namespace latelight::data
