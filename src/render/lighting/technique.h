// The interface of lighting techniques. A technique reads the G-buffer and the lights and writes the lit picture. Each
// has a folder under src/render/lighting with its C++ and its shaders; the folder NAME defines `TechniqueInfo
// technique_NAME()`, and the registry needs nothing else.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "render/frame/frame.h"
#include "render/settings/technique_info.h"

namespace latelight::render {

std::span<const TechniqueInfo> techniques();                // those that produce the same picture
std::span<const TechniqueInfo> allTechniques();             // and those that trace paths
const TechniqueInfo& findTechnique(std::string_view name);  // of all; throws Error(Usage) that lists the names
std::string techniquesThatCompute();                        // "a, b or c": those without `draws`

}  // namespace latelight::render
