// The id manifest: the meaning of the ids in an image.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "output/aov.h"

namespace latelight::output {

// Returns "/forest/tree", or "/forest/tree/instance7" for a copy: the path from which its id is computed.
std::string pathOf(const std::string& node, const std::optional<uint32_t>& copy);

// A primitive of a node, or of one of the node's copies.
struct IdPart {
  uint32_t id = 0;
  std::string node;              // the node's path
  std::optional<uint32_t> copy;  // index of the copy, if EXT_mesh_gpu_instancing copies the node
  std::string mesh;              // the node's mesh
  uint32_t primitive = 0;        // index in the mesh
  uint32_t material = 0;         // id of its material
};

// A node with all parts that have its id: its own parts and, in a group, those of the nodes below it.
struct IdEntry {
  uint32_t id = 0;
  std::string node;              // the node's path
  std::optional<uint32_t> copy;  // index of the copy, if copies have ids of their own
  uint32_t parent = 0;           // id of the node's parent; 0: the node is a root
  std::string mesh;              // the node's own mesh; empty: none
  bool skinned = false;          // a skin deforms one of its parts
  std::vector<IdPart> parts;     // in scene order; empty: listed only because descendants have parts
};

struct IdMaterial {
  uint32_t id = 0;
  std::string name;
  uint32_t index = 0;  // in the scene's list
};

struct IdManifest {
  // Both lists are sorted by id.
  std::vector<IdEntry> ids;
  std::vector<IdMaterial> materials;

  // Returns the names of the materials of an entry's parts, without repeats, in order.
  std::vector<std::string> materialsOf(const IdEntry& entry) const;
};

// Returns null if the manifest has no such id.
const IdEntry* entryOf(const IdManifest& manifest, uint32_t id);

// Returns the part of the manifest that is visible in those of these images that are `id`, `part` and `material`,
// including all ancestors of the visible nodes.
IdManifest shownIn(const IdManifest& all, std::span<const AovImage> pictures);

// Returns {"<id>": {"node": ..., "parent": ..., "mesh": ..., "materials": [...], "skinned": ..., "parts": [...]}, ...},
// with ids in decimal. Copies also have "copy".
nlohmann::ordered_json describeIds(const IdManifest& manifest);
// Returns {"<id>": {"name": ..., "index": ...}, ...}
nlohmann::ordered_json describeMaterials(const IdManifest& manifest);

// Returns one JSON object with both, as "ids" and "materials".
std::string idManifestText(const IdManifest& manifest);

}  // namespace latelight::output
