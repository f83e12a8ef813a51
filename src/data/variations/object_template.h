// What is scattered: meshes and materials of the scene, of a node or of another file, and the box around them.
#pragma once

#include <vector>

#include "base/memory.h"
#include "data/spec.h"
#include "data/variations/oriented_box.h"
#include "scene/edit.h"

namespace latelight::data {

struct ObjectTemplate {
  std::string name;  // what the job calls it: a file or a node
  std::vector<scene::ObjectPart> parts;
  OrientedBox box;     // along the world's axes, around all vertices
  MemoryClaim memory;  // of a file's share of the scene
};

// {"node": ...} or {"file": ...}, whose meshes, materials and textures are added to the scene.
ObjectTemplate readTemplate(Spec& spec, scene::Scene& scene);

}  // namespace latelight::data
