#include "output/id_manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <unordered_set>
#include <utility>

namespace latelight::output {
namespace {

using Json = nlohmann::ordered_json;

// Appends directly to the vector of an ordered_json object, because [] searches the vector each time. Ids are unique.
void append(Json::object_t& object, uint32_t id, Json value) {
  static_cast<std::vector<Json::object_t::value_type>&>(object).emplace_back(std::to_string(id), std::move(value));
}

Json describePart(const IdPart& part) {
  Json json{{"id", part.id}, {"node", part.node}};
  if (part.copy) json["copy"] = *part.copy;
  json["mesh"] = part.mesh;
  json["primitive"] = part.primitive;
  json["material"] = part.material;
  return json;
}

Json describeEntry(const IdEntry& entry, const std::vector<std::string>& materials) {
  Json json{{"node", entry.node}};
  if (entry.copy) json["copy"] = *entry.copy;
  json["parent"] = entry.parent;
  json["mesh"] = entry.mesh;
  json["materials"] = materials;
  json["skinned"] = entry.skinned;
  Json& parts = json["parts"] = Json::array();
  for (const IdPart& part : entry.parts) parts.push_back(describePart(part));
  return json;
}

// Searches a list that is sorted by id. Returns null if the id is absent.
template <typename Entry>
const Entry* find(const std::vector<Entry>& entries, uint32_t id) {
  const auto found = std::ranges::lower_bound(entries, id, {}, &Entry::id);
  return found == entries.end() || found->id != id ? nullptr : &*found;
}

using Ids = std::unordered_set<uint32_t>;

Ids idsIn(std::span<const AovImage> pictures, Aov aov) {
  Ids shown;
  for (const AovImage& picture : pictures) {
    uint32_t last = 0;
    if (picture.aov != aov) continue;
    for (const uint32_t id : picture.ids)
      if (id != std::exchange(last, id)) shown.insert(id);
  }
  return shown;
}

}  // namespace

std::string pathOf(const std::string& node, const std::optional<uint32_t>& copy) {
  return copy ? fmt::format("{}/instance{}", node, *copy) : node;
}

std::vector<std::string> IdManifest::materialsOf(const IdEntry& entry) const {
  std::unordered_set<std::string_view> seen;
  std::vector<std::string> names;
  for (const IdPart& part : entry.parts) {
    const IdMaterial* found = find(materials, part.material);
    if (!found) continue;
    if (seen.insert(found->name).second) names.push_back(found->name);
  }
  return names;
}

const IdEntry* entryOf(const IdManifest& manifest, uint32_t id) {
  return find(manifest.ids, id);
}

IdManifest shownIn(const IdManifest& all, std::span<const AovImage> pictures) {
  Ids ids = idsIn(pictures, Aov::Id), materials = idsIn(pictures, Aov::Material);
  const Ids parts = idsIn(pictures, Aov::Part);
  const auto isShown = [&](const IdPart& part) { return parts.contains(part.id); };
  for (const IdEntry& entry : all.ids)
    if (std::ranges::any_of(entry.parts, isShown)) ids.insert(entry.id);
  const std::vector<uint32_t> lowest(ids.begin(), ids.end());
  for (uint32_t id : lowest)
    for (const IdEntry* entry; (entry = entryOf(all, id)) && ids.insert(entry->parent).second;) id = entry->parent;
  IdManifest shown;
  for (const IdEntry& entry : all.ids)
    if (ids.contains(entry.id)) shown.ids.push_back(entry);
  for (const IdEntry& entry : shown.ids)
    for (const IdPart& part : entry.parts) materials.insert(part.material);
  for (const IdMaterial& material : all.materials)
    if (materials.contains(material.id)) shown.materials.push_back(material);
  return shown;
}

Json describeIds(const IdManifest& manifest) {
  Json::object_t object;
  for (const IdEntry& entry : manifest.ids) append(object, entry.id, describeEntry(entry, manifest.materialsOf(entry)));
  return object;
}

Json describeMaterials(const IdManifest& manifest) {
  Json::object_t object;
  for (const IdMaterial& material : manifest.materials)
    append(object, material.id, {{"name", material.name}, {"index", material.index}});
  return object;
}

std::string idManifestText(const IdManifest& manifest) {
  const Json json{{"ids", describeIds(manifest)}, {"materials", describeMaterials(manifest)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";  // names need not be UTF-8
}

}  // namespace latelight::output
