// The JSON schema of a job, and the validation of jobs against it.
#pragma once

#include <nlohmann/json.hpp>

#include "data/batch/job_file.h"

namespace latelight::data {

// Returns schema.json, completed with the picture options from the table of options and with the schemas of cameras and
// variations as definitions.
const nlohmann::ordered_json& jobSchema();

// Throws Error(Usage) for unknown keys, missing keys, and values that violate the schema. The message names the key and
// its line in the file.
void checkJob(const JobDocument& job);

}  // namespace latelight::data
