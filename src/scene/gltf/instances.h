// Instances with their ids and transforms, and the list of distinct meshes that they require.
#pragma once

#include <vector>

#include "scene/gltf/mesh.h"

namespace latelight::scene::gltf {

// Fills scene.instances, and appends a default material if a primitive requires it. Returns the requests for meshes,
// which Instance::mesh indexes.
std::vector<MeshRequest> placeInstances(const Document& document, const Hierarchy& hierarchy, int variant,
                                        const LoadOptions& options, Scene& scene);

}  // namespace latelight::scene::gltf
