// Reads the options that a job specifies for a format, key by key.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "output/aov.h"

namespace latelight::data {

// Every function throws Error(Usage) that names the key if its value is invalid. `preset` is the value if the key is
// missing.
class FormatOptions {
 public:
  FormatOptions(std::string_view format, const nlohmann::ordered_json& options) : format_(format), options_(options) {}

  bool flag(std::string_view key, bool preset);
  double number(std::string_view key, double preset, double minimum, double maximum);
  std::string text(std::string_view key, std::string_view preset);
  std::string choice(std::string_view key, std::initializer_list<std::string_view> names);  // the first is the default
  std::vector<output::Aov> outputs(std::string_view key, const std::vector<output::Aov>& preset);
  // Return a file name below the data set's folder with this extension. The name of a file per frame must contain
  // "{name}", the placeholder for the frame's name.
  std::string frameFile(std::string_view key, std::string_view preset, std::string_view ending);
  std::string setFile(std::string_view key, std::string_view preset, std::string_view ending);
  // Returns the name of a folder below the data set's folder.
  std::string setFolder(std::string_view key, std::string_view preset);
  const nlohmann::ordered_json* find(std::string_view key);  // null if the key is missing

  // Rejects keys that no function above has read. Call it last.
  void finish() const;

 private:
  [[noreturn]] void wrong(std::string_view key, std::string_view takes) const;
  std::string file(std::string_view key, std::string_view preset, std::string_view ending);

  std::string_view format_;
  const nlohmann::ordered_json& options_;
  std::vector<std::string> known_;
};

}  // namespace latelight::data
