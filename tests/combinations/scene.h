// A small scene with every kind of light and material, and geometry of negligible cost.
#pragma once

#include "scene/scene.h"

namespace latelight::render::test {

scene::Scene everyKind();

std::vector<std::string> layoutNames();
size_t turnOf(const std::string& layout);  // its number: what takes turns begins with another one at each layout

}  // namespace latelight::render::test
