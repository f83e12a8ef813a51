// Reads a job file, JSON or YAML, into a JSON document with the line numbers of its keys.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "base/memory.h"

namespace latelight::data {

struct JobDocument {
  std::string name;  // the file's name, for messages; empty: a job from command line options only
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  std::map<std::string, int> lines;     // line numbers by path: "options.exposure", "scenes[1]"
  std::shared_ptr<MemoryClaim> memory;  // for `json`

  // Returns the position of a key as the beginning of a message: "job.yaml:7: options.exposure".
  std::string place(const std::string& path) const;
};

// Reads a file that ends in .json, .yaml or .yml. Throws Error(BadInput) if it cannot be read, and Error(Usage) with
// the line for syntax errors and duplicate keys.
JobDocument readJobFile(const std::filesystem::path& path);

}  // namespace latelight::data
