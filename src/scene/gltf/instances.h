// Instances with their ids and transforms, and the list of distinct meshes they need.
#pragma once

#include <vector>

#include "scene/gltf/mesh.h"

namespace latelight::scene::gltf {

// Fills scene.instances; appends a default material if a primitive needs it. Instance::mesh counts into the result.
std::vector<MeshRequest> placeInstances(const Document& document, const Hierarchy& hierarchy, int variant,
                                        Scene& scene);

}  // namespace latelight::scene::gltf
