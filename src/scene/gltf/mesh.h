// Converts primitives to meshes: one scene::Mesh for each distinct geometry in its rest pose.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <vector>

#include "scene/gltf/document.h"
#include "scene/gltf/nodes.h"
#include "scene/scene.h"
#include "scene/tangents.h"

namespace latelight::scene::gltf {

// The inputs of one scene::Mesh. Equal requests produce equal meshes.
struct MeshRequest {
  int mesh = 0, primitive = 0;
  int skin = -1;                             // skin to apply in its rest pose, in the file's own frame; -1: none
  std::vector<double> weights;               // rest weights of morph targets; empty: morph targets are ignored
  int weightsNode = -1;                      // glTF node with animated weights; -1: none
  std::optional<TangentSpace> tangentSpace;  // set if tangents are required
  bool copiesUv = false;                     // if TEXCOORD_1 is a copy of TEXCOORD_0
  bool operator==(const MeshRequest&) const = default;
};

// Returns the mesh's number of morph targets: the maximum over its primitives. Exporters omit targets from primitives
// that they do not move.
size_t targetCount(const file::Mesh& mesh);

// Returns the name of a mesh of the file, or "mesh<index>" if it has none.
std::string meshName(const Document& document, int mesh);

// Returns the number of the primitive's triangles; 0 for points, lines and primitives without positions.
size_t triangleCount(const Document& document, const file::Primitive& primitive);

// Builds the mesh. Throws Error(BadInput) that names the primitive. Thread-safe.
Mesh buildMesh(const Document& document, const Hierarchy& hierarchy, const MeshRequest& request);

// Sets Mesh::morphable if the primitive has morph targets that no animation moves. Thread-safe.
void addMorphable(const Document& document, const Hierarchy& hierarchy, MeshRequest request, Mesh& mesh);

}  // namespace latelight::scene::gltf
