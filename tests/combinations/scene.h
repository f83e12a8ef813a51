// A small scene with every kind of light and of material, whose geometry costs next to nothing.
#pragma once

#include "scene/scene.h"

namespace latelight::render::test {

scene::Scene everyKind();

std::vector<std::string> layoutNames();

}  // namespace latelight::render::test
