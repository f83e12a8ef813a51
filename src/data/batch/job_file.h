// A job's file as a document: JSON or YAML, and the lines that its keys are on.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "base/memory.h"

namespace latelight::data {

struct JobDocument {
  std::string name;  // of its file, for messages; empty: a job of options alone
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  std::map<std::string, int> lines;     // by path: "options.exposure", "scenes[1]"
  std::shared_ptr<MemoryClaim> memory;  // of `json`

  // Where a key stands, to begin a sentence with: "job.yaml:7: options.exposure".
  std::string place(const std::string& path) const;
};

// A file that ends in .json, .yaml or .yml. Throws Error: BadInput for one that can't be read, Usage with the line
// where it is not in that language, or has a key twice.
JobDocument readJobFile(const std::filesystem::path& path);

}  // namespace latelight::data
