// The id manifest: the meaning of the ids in a picture.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "output/aov.h"

namespace latelight::output {

// "/forest/tree", or of a copy "/forest/tree/instance7", as its id is made from.
std::string pathOf(const std::string& node, const std::optional<uint32_t>& copy);

// A primitive of a node, or of one of the node's copies.
struct IdPart {
  uint32_t id = 0;
  std::string node;              // the node's path
  std::optional<uint32_t> copy;  // which one, of a node that EXT_mesh_gpu_instancing copies
  std::string mesh;              // the node's
  uint32_t primitive = 0;        // of the mesh
  uint32_t material = 0;         // its id
};

// A node with all parts that have its id: its own, and in a group those of the nodes below it.
struct IdEntry {
  uint32_t id = 0;
  std::string node;              // the node's path
  std::optional<uint32_t> copy;  // which one, where copies have ids of their own
  uint32_t parent = 0;           // the id of the node's parent; 0: it is a root
  std::string mesh;              // the node's own; empty: it has none
  bool skinned = false;          // a skin moves one of its parts
  std::vector<IdPart> parts;     // in scene order; empty: listed because it has descendants with parts
};

struct IdMaterial {
  uint32_t id = 0;
  std::string name;
  uint32_t index = 0;  // in the scene's list
};

struct IdManifest {
  // Each sorted by id.
  std::vector<IdEntry> ids;
  std::vector<IdMaterial> materials;

  // The names of the materials of an entry's parts, without repeats, in order.
  std::vector<std::string> materialsOf(const IdEntry& entry) const;
};

// Null where there is none of that id.
const IdEntry* entryOf(const IdManifest& manifest, uint32_t id);

// What of it the pictures of `id`, `part` and `material` among these show, with the nodes above.
IdManifest shownIn(const IdManifest& all, std::span<const AovImage> pictures);

// {"<id>": {"node": ..., "parent": ..., "mesh": ..., "materials": [...], "skinned": ..., "parts": [...]}, ...}, ids in
// decimal; copies also have "copy".
nlohmann::ordered_json describeIds(const IdManifest& manifest);
// {"<id>": {"name": ..., "index": ...}, ...}
nlohmann::ordered_json describeMaterials(const IdManifest& manifest);

// Both, as "ids" and "materials" of one JSON object.
std::string idManifestText(const IdManifest& manifest);

}  // namespace latelight::output
