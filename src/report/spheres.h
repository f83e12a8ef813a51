// Interactive spheres that show the errors of normal encodings. The page's script draws them on canvases from the maps
// of `latelight study normals`.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "report/planes.h"
#include "study/table.h"

namespace latelight::report {

// Returns the data for the script. `errors` is the study's table "normals"; its means and maxima are shown below the
// spheres.
nlohmann::ordered_json describeSpheres(std::span<const uint32_t> bits, const study::Table& errors, Planes& planes);

std::string spheresHtml(std::span<const uint32_t> bits);

}  // namespace latelight::report
