// A small scene with every kind of light and material, and geometry of negligible cost.
#pragma once

#include "scene/scene.h"

namespace latelight::render::test {

scene::Scene everyKind();

std::vector<std::string> layoutNames();
// its number: whatever is tested in rotation begins with another choice for each layout
size_t turnOf(const std::string& layout);

}  // namespace latelight::render::test
