// The errors of normal encodings over the sphere, to turn: canvases, which the page's script draws from the maps of
// `latelight study normals`.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "report/planes.h"
#include "study/table.h"

namespace latelight::report {

// What the script needs. `errors`: the table "normals" of the study, whose means and maxima stand below the spheres.
nlohmann::ordered_json describeSpheres(std::span<const uint32_t> bits, const study::Table& errors, Planes& planes);

std::string spheresHtml(std::span<const uint32_t> bits);

}  // namespace latelight::report
