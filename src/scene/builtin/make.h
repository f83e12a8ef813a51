// The functions that generate the built-in scenes.
#pragma once

#include "scene/scene.h"

namespace latelight::scene::builtin {

Scene makeBoxes();
Scene makeSpheres();
struct HallParameters {
  uint64_t triangles;
  uint32_t lights;
  uint64_t seed;
  bool glass;
  uint32_t textureSlots;  // LoadOptions::textureSlots
};
Scene makeTriangles(uint64_t count, double size);  // size in pixels
Scene makeHall(const HallParameters& parameters);

}  // namespace latelight::scene::builtin
