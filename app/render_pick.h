// --pick: prints what is visible at given pixels, as text and in the report.
#pragma once

#include <glm/vec2.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "render/submit/picking.h"

namespace latelight::app {

// Parses "x,y" with integers. Throws Error(Usage).
std::vector<glm::uvec2> parsePixels(const std::vector<std::string>& texts);

// Prints readable text. `frame` names the frame of positions, and `normalFrame` that of normals.
void printPicked(const std::vector<render::Picked>& picked, const std::string& frame, const std::string& normalFrame);
nlohmann::ordered_json describePicked(const std::vector<render::Picked>& picked);

}  // namespace latelight::app
