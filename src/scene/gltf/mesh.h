// Primitives become meshes: one scene::Mesh for each distinct geometry, posed.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <vector>

#include "scene/gltf/document.h"
#include "scene/gltf/nodes.h"
#include "scene/scene.h"

namespace latelight::scene::gltf {

// The texture coordinates whose directions tangents follow: a UV set, and the linear part of its texture's transform.
struct TangentSpace {
  uint32_t uvSet = 0;
  vec2 row0{1, 0}, row1{0, 1};
  bool operator==(const TangentSpace&) const = default;
};

// The inputs of one scene::Mesh. Equal requests give equal meshes.
struct MeshRequest {
  int mesh = 0, primitive = 0;
  int skin = -1;                             // its bind pose, in the file's own frame; -1: none
  std::vector<double> weights;               // of morph targets at rest; empty: morph targets are ignored
  int weightsNode = -1;                      // the glTF node whose weights are animated; -1: none
  std::optional<TangentSpace> tangentSpace;  // where tangents are needed
  bool operator==(const MeshRequest&) const = default;
};

// The morph targets of the mesh: as many as that of its primitives has that has most. Exporters leave them out of
// primitives that none moves.
size_t targetCount(const tinygltf::Mesh& mesh);

// The name of a mesh of the file; "mesh<index>" without one.
std::string meshName(const Document& document, int mesh);

// Triangles the primitive has; 0 for points, lines and primitives without positions.
size_t triangleCount(const Document& document, const tinygltf::Primitive& primitive);

// Throws Error(BadInput) that names the primitive. Thread-safe.
Mesh buildMesh(const Document& document, const Hierarchy& hierarchy, const MeshRequest& request);

}  // namespace latelight::scene::gltf
