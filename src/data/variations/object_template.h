// A template for scattered objects: meshes, materials and lights, from a node of the scene or from another file, and
// the bounding box of the meshes.
#pragma once

#include <optional>
#include <vector>

#include "base/memory.h"
#include "data/spec.h"
#include "data/variations/oriented_box.h"
#include "data/variations/variation.h"
#include "scene/edit.h"

namespace latelight::data {

struct ObjectTemplate {
  std::string name;                     // the file or node, as named in the job
  std::optional<scene::NodeCopy> copy;  // of copies, except for the displacement; empty: a file
  std::vector<scene::ObjectPart> parts;
  std::vector<scene::Light> lights;  // in the world, without nodes; none is directional
  OrientedBox box;                   // axis-aligned in the world, around all vertices
  MemoryClaim memory;                // for the data that a file adds to the scene
};

// Reads {"node": ...}, or {"file": ...} with options for the file. The meshes, materials and textures of a file are
// added to the scene.
ObjectTemplate readTemplate(Spec& spec, const VariationContext& context);

}  // namespace latelight::data
