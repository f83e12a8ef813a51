// The functions behind the names of the built-in scenes.
#pragma once

#include "scene/scene.h"

namespace latelight::scene::builtin {

Scene makeBoxes();
Scene makeSpheres();
Scene makeHall(uint64_t triangles, uint32_t lights, uint64_t seed);

}  // namespace latelight::scene::builtin
