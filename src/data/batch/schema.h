// The JSON schema of a job, and what it finds wrong.
#pragma once

#include <nlohmann/json.hpp>

#include "data/batch/job_file.h"

namespace latelight::data {

// schema.json, with the options of a picture from their table, and the schemas of cameras and variations as
// definitions.
const nlohmann::ordered_json& jobSchema();

// Throws Error(Usage) with a sentence that names the key, and its line in the file: one that is not known or is
// missing, or whose value is not what the schema says.
void checkJob(const JobDocument& job);

}  // namespace latelight::data
