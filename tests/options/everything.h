// One small glTF file with every kind of content that affects rendering.
#pragma once

#include <cstddef>
#include <vector>

namespace latelight::app {

// What may be left out of it, since passes and pipelines depend on what is there at all.
struct Kinds {
  bool opaque = true, masked = true, blended = true, lights = true, layered = false;
};

// Textured, masked, blended, unlit and double-sided surfaces; a mirrored node; one without normals and texture
// coordinates; one skinned and one morphed; where it is asked for, some with layers; lights of each kind that move; a
// camera that moves, "front", and an orthographic one, "above". Animations "move" and "sway", variants "red" and
// "blue", lights "sun", "lamp" and "spot".
std::vector<std::byte> everythingModel(const Kinds& kinds = {});

}  // namespace latelight::app
