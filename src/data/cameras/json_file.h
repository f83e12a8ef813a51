// JSON files that others wrote.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/json_builder.h"

namespace latelight::data {

// Throws Error(BadInput) with the line and what is wrong there.
JsonDocument readJson(const std::filesystem::path& file);
void writeJson(const std::filesystem::path& file, const nlohmann::ordered_json& json);

// A member of an object: a finite number, or `normal` where there is none.
double numberIn(const nlohmann::ordered_json& object, const char* key, double normal, const std::string& where);
// So many numbers, in one list or in rows.
std::vector<double> numbersIn(const nlohmann::ordered_json& object, const char* key, size_t count,
                              const std::string& where);

}  // namespace latelight::data
