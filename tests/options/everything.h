// One small glTF file with every kind of content that affects rendering.
#pragma once

#include <cstddef>
#include <vector>

namespace latelight::app {

// Optional content; passes and pipelines depend on whether it exists.
struct Kinds {
  bool opaque = true, masked = true, blended = true, lights = true, layered = false;
};

// Textured, masked, blended, unlit and double-sided surfaces; a mirrored node; a mesh without normals and texture
// coordinates; a skinned and a morphed one; optionally, layered materials; moving lights of each kind; a moving camera,
// "front", and an orthographic one, "above". Animations "move" and "sway", variants "red" and "blue", lights "sun",
// "lamp" and "spot".
std::vector<std::byte> everythingModel(const Kinds& kinds = {});

}  // namespace latelight::app
