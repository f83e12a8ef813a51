#include "render/submit/id_manifest.h"

#include <algorithm>
#include <unordered_map>

namespace latelight::render {

namespace {

class Collector {
 public:
  explicit Collector(const scene::Scene& scene) : scene_(scene), owners_(scene.nodes.size()) {
    for (uint32_t i = 0; i < owners_.size(); ++i) {  // parents first
      const scene::Node& node = scene.nodes[i];
      const bool shared = node.parent >= 0 && scene.nodes[size_t(node.parent)].id == node.id;
      owners_[i] = shared ? owners_[size_t(node.parent)] : i;
    }
  }

  output::IdManifest run() {
    for (const scene::Instance& instance : scene_.instances) {
      if (instance.removed) continue;
      output::IdEntry& entry = entryOf(instance);
      entry.skinned |= instance.posed;
      const scene::Node& node = scene_.nodes[instance.node];
      entry.parts.push_back({instance.part, node.path, copyOf(instance), node.mesh, instance.primitive,
                             scene_.materials[instance.material].data.id});
    }
    for (uint32_t i = 0; i < scene_.materials.size(); ++i)
      if (!scene_.materials[i].removed)
        manifest_.materials.push_back({scene_.materials[i].data.id, scene_.materials[i].name, i});
    std::ranges::sort(manifest_.ids, {}, &output::IdEntry::id);
    std::ranges::sort(manifest_.materials, {}, &output::IdMaterial::id);
    return std::move(manifest_);
  }

 private:
  static std::optional<uint32_t> copyOf(const scene::Instance& instance) {
    if (instance.copy < 0) return std::nullopt;
    return static_cast<uint32_t>(instance.copy);
  }

  output::IdEntry& entryOf(const scene::Instance& instance) {
    const scene::Node& node = scene_.nodes[instance.node];
    addNode(instance.node);
    const auto [place, isNew] = places_.try_emplace(instance.id, manifest_.ids.size());
    if (isNew) manifest_.ids.push_back({instance.id, node.path, copyOf(instance), node.id, node.mesh, false, {}});
    return manifest_.ids[place->second];
  }

  // Adds the node that owns this node's id, and all its ancestors.
  void addNode(uint32_t index) {
    for (int above = int(index); above >= 0;) {
      const scene::Node& node = scene_.nodes[owners_[size_t(above)]];
      if (!places_.try_emplace(node.id, manifest_.ids.size()).second) return;
      const uint32_t parent = node.parent < 0 ? 0 : scene_.nodes[size_t(node.parent)].id;
      manifest_.ids.push_back({node.id, node.path, std::nullopt, parent, node.mesh, false, {}});
      above = node.parent;
    }
  }

  const scene::Scene& scene_;
  std::vector<uint32_t> owners_;                 // per node, the topmost of the nodes that share its id
  std::unordered_map<uint32_t, size_t> places_;  // indices of ids in manifest_.ids
  output::IdManifest manifest_;
};

}  // namespace

output::IdManifest idManifest(const scene::Scene& scene) {
  return Collector(scene).run();
}

}  // namespace latelight::render
