#include "data/variations/variations.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.h"
#include "data/variations/pattern.h"
#include "data/variations/variation.h"
#include "render/submit/id_manifest.h"
#include "scene/edit_slots.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr VariationKind kKinds[] = {
    {"materials", "color, roughness, metalness and emission of materials", varyMaterials},
    {"textures", "replacement textures for material slots", varyTextures, texturesFiles},
    {"lights", "intensity, color, position and number of the scene's lights", varyLights},
    {"addedLights", "additional lights", addLights},
    {"environments", "a choice of environments and their rotation", varyEnvironments, environmentsFiles},
    {"transforms", "translation, rotation and scale of nodes", varyTransforms},
    {"visibility", "visibility of nodes", varyVisibility},
    {"scatter", "objects on a surface or in a volume, without overlap", scatterObjects, scatterFiles},
};

std::unique_ptr<Variation> makeVariation(const Json& value, const std::string& path, const VariationContext& context) {
  Spec spec(value, path);
  const std::string type = spec.text("type");
  const auto kind = std::ranges::find(kKinds, type, &VariationKind::name);
  if (kind == std::end(kKinds)) {
    std::vector<std::string_view> names;
    for (const VariationKind& known : kKinds) names.push_back(known.name);
    badUsage("{}.type must be one of {}, not \"{}\"", path, fmt::join(names, ", "), type);
  }
  std::unique_ptr<Variation> variation = kind->make(spec, context);
  spec.finish();
  return variation;
}

}  // namespace

std::span<const VariationKind> variationKinds() {
  return kKinds;
}

std::vector<std::filesystem::path> variationFiles(const Json& spec, const scene::LoadOptions& load) {
  std::vector<std::filesystem::path> files;
  if (!spec.is_array()) return files;
  for (const Json& value : spec) {
    const auto kind = std::ranges::find_if(kKinds, [&](const VariationKind& known) {
      return value.is_object() && value.value("type", Json()) == known.name;
    });
    if (kind == std::end(kKinds) || !kind->files) continue;
    const std::vector<std::filesystem::path> own = kind->files(value, load);
    files.insert(files.end(), own.begin(), own.end());
  }
  return files;
}

bool addsNormalMaps(const Json& spec) {
  return spec.is_array() && std::ranges::any_of(spec, [](const Json& value) {
           return value.is_object() && value.value("type", Json()) == "textures" &&
                  value.value("slot", Json()) == "normal";
         });
}

struct Variations::Impl {
  scene::Scene& scene;
  uint64_t seed;
  struct Entry {
    std::string type;
    std::unique_ptr<Variation> variation;
  };
  std::vector<Entry> entries;
  // The initial values of elements that any variation has changed.
  std::map<uint32_t, scene::Material> materials;
  std::map<uint32_t, scene::Light> lights;
  std::map<uint32_t, scene::dmat4> transforms;
  // The state of the applied variation.
  std::vector<uint32_t> hidden, addedInstances, addedLights;
  std::map<uint32_t, scene::dmat4> movedNodes;
  std::string environment;
  std::optional<double> environmentRotation;

  void takeBack();
  void change(const Draft& draft);
  void hide(const std::set<uint32_t>& nodes);
};

// Undoes change() in reverse order, so that the free slots in the scene's lists are restored. Elements added next then
// use the same slots as in a scene without any variation.
void Variations::Impl::takeBack() {
  for (const uint32_t instance : hidden) scene::restoreInstance(scene, instance);
  for (size_t i = addedInstances.size(); i-- > 0;) scene::removeInstance(scene, addedInstances[i]);
  for (size_t i = addedLights.size(); i-- > 0;) scene::removeLight(scene, addedLights[i]);
  hidden.clear(), addedInstances.clear(), addedLights.clear();
  if (scene.edits.ids) scene.edits.ids->nodes.forgetNumbers();
  for (const auto& [index, material] : materials) scene::setMaterial(scene, index, material);
  for (const auto& [index, light] : lights) scene::setLight(scene, index, light);
  for (const auto& [index, toWorld] : transforms) scene::setTransform(scene, index, toWorld);
}

void Variations::Impl::change(const Draft& draft) {
  for (const auto& [index, material] : draft.materials) {
    materials.try_emplace(index, scene.materials[index]);
    scene::setMaterial(scene, index, material);
  }
  for (const auto& [index, light] : draft.lights) {
    lights.try_emplace(index, scene.lights[index]);
    scene::setLight(scene, index, light);
    // Animations no longer move the light. In other scenes it stays at its node, for files of the frame's scene.
    const bool isMoved = light.node >= 0 && draft.movedNodes.contains(static_cast<uint32_t>(light.node));
    if (isMoved && scene.rig.isAnimated()) scene.lights[index].node = -1;
  }
  for (const auto& [index, toWorld] : draft.transforms) {
    transforms.try_emplace(index, scene.instances[index].toWorld);
    scene::setTransform(scene, index, toWorld);
  }
  for (const scene::Light& light : draft.addedLights) addedLights.push_back(scene::addLight(scene, light));
  for (const AddedObject& object : draft.addedObjects)
    for (const uint32_t instance : scene::addObject(scene, object.parts, object.name, object.copy))
      addedInstances.push_back(instance);
  hide(draft.hiddenNodes);
  movedNodes = draft.movedNodes;
  environment = draft.environment;
  environmentRotation = draft.environmentRotation;
}

void Variations::Impl::hide(const std::set<uint32_t>& nodes) {
  if (nodes.empty()) return;
  const auto above = selectedAbove(scene, {nodes.begin(), nodes.end()});
  for (uint32_t instance = 0; instance < above.size(); ++instance) {
    if (above[instance].empty()) continue;
    scene::removeInstance(scene, instance);
    hidden.push_back(instance);
  }
}

Variations::Variations(const Json& spec, scene::Scene& scene, uint64_t seed, const scene::LoadOptions& load)
    : impl_(std::make_unique<Impl>(Impl{.scene = scene, .seed = seed})) {
  if (!spec.is_null() && !spec.is_array()) badUsage("variations must be a list of objects, not {}", shown(spec));
  const scene::LoadOptions ofFiles{.allowOutside = load.allowOutside,
                                   .unit = load.unit,
                                   .upAxis = load.upAxis,
                                   .pointRadius = load.pointRadius,
                                   .tangents = addsNormalMaps(spec)};
  for (size_t i = 0; i < spec.size(); ++i) {
    std::unique_ptr<Variation> variation = makeVariation(spec[i], fmt::format("variations[{}]", i), {scene, ofFiles});
    impl_->entries.push_back({spec[i]["type"].get<std::string>(), std::move(variation)});
  }
}
Variations::~Variations() = default;

Json Variations::apply(uint64_t number) {
  impl_->takeBack();
  Draft draft{.scene = impl_->scene};
  Json drawn = Json::array();
  for (const Impl::Entry& entry : impl_->entries) {
    Json& record = drawn.emplace_back(Json{{"type", entry.type}});
    record.update(entry.variation->draw({impl_->seed, number}, draft));
  }
  impl_->change(draft);
  return drawn;
}

output::IdManifest Variations::idsOfAll() const {
  scene::Scene& scene = impl_->scene;
  output::IdManifest all = render::idManifest(scene);
  scene::UniqueNames names = scene::idsOf(scene).nodes;
  for (const Impl::Entry& entry : impl_->entries)
    for (const AddedObject& object : entry.variation->possibleObjects()) {
      const auto [path, id] = names.make("/" + object.name);
      output::IdEntry& added = all.ids.emplace_back(
          output::IdEntry{.id = id, .node = path, .mesh = scene.meshes[object.parts.front().mesh].name});
      for (const scene::ObjectPart& part : object.parts)
        added.parts.push_back({.node = path, .material = scene.materials[part.material].data.id});
    }
  std::ranges::sort(all.ids, {}, &output::IdEntry::id);
  return all;
}

const std::map<uint32_t, scene::dmat4>& Variations::movedNodes() const {
  return impl_->movedNodes;
}

const std::string& Variations::environment() const {
  return impl_->environment;
}

// The last choice replaces the others, as in Draft::environment.
std::vector<std::string> Variations::possibleEnvironments() const {
  std::vector<std::string> names;
  for (const Impl::Entry& entry : impl_->entries)
    if (std::vector<std::string> own = entry.variation->possibleEnvironments(); !own.empty()) names = std::move(own);
  return names;
}

std::optional<double> Variations::environmentRotation() const {
  return impl_->environmentRotation;
}

}  // namespace latelight::data
