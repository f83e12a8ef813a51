// Reads and writes JSON camera files of other programs.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/json_builder.h"

namespace latelight::data {

// Throws Error(BadInput) with the line and the error there.
JsonDocument readJson(const std::filesystem::path& file);
void writeJson(const std::filesystem::path& file, const nlohmann::ordered_json& json);

// Returns a member of an object, or `normal` if it is missing. Throws Error(BadInput) if it is not a finite number.
double numberIn(const nlohmann::ordered_json& object, const char* key, double normal, const std::string& where);
// Returns `count` finite numbers, from one list or a list of rows. Throws Error(BadInput) if they are missing.
std::vector<double> numbersIn(const nlohmann::ordered_json& object, const char* key, size_t count,
                              const std::string& where);

}  // namespace latelight::data
