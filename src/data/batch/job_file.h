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
  // Line numbers by path: "options.exposure", "scenes[1]". Paths below these have none; 0: not from the file.
  std::map<std::string, int> lines;
  std::shared_ptr<MemoryClaim> memory;  // for `json`

  // Returns the position of a key as the beginning of a message: "job.yaml:7: options.exposure". Deeper keys have the
  // line of the entry that contains them.
  std::string place(const std::string& path) const;
  // Adds the file and the line to a message about cameras or variations that begins with the path of a key, such as
  // "variations[0].scale must be a number", and to a message about options of the file, such as "--aa fxaa requires".
  // The line is that of the first option in the message that the file sets. Returns other messages as they are.
  std::string located(const std::string& message) const;
  // Forgets the lines of a key and of everything in it. place() does not name the file for it, because an option of the
  // command line has replaced its value.
  void forgetLines(const std::string& path);

 private:
  std::string optionIn(const std::string& message) const;
};

// Reads a file that ends in .json, .yaml or .yml. Throws Error(BadInput) if it cannot be read, and Error(Usage) with
// the line for syntax errors and duplicate keys.
JobDocument readJobFile(const std::filesystem::path& path);

}  // namespace latelight::data
