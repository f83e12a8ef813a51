// Decodes primitives that are compressed with KHR_draco_mesh_compression.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scene/gltf/accessor.h"

namespace latelight::scene::gltf {

struct DracoMesh {
  std::vector<uint32_t> indices;               // a triangle list
  std::map<std::string, Elements> attributes;  // the compressed attributes
};

// Decodes a primitive that has the extension. Throws Error(BadInput) with `name`.
DracoMesh decodeDraco(const Document& document, const file::Primitive& primitive, const std::string& name);

}  // namespace latelight::scene::gltf
