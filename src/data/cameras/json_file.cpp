#include "data/cameras/json_file.h"

#include <cmath>

#include "base/error.h"
#include "base/files.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

void append(const Json& value, std::vector<double>& numbers, const std::string& where, const char* key) {
  if (value.is_array()) {
    for (const Json& part : value) append(part, numbers, where, key);
    return;
  }
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    badInput("{}: \"{}\" has no finite numbers", where, key);
  numbers.push_back(value.get<double>());
}

}  // namespace

JsonDocument readJson(const std::filesystem::path& file) {
  const std::vector<std::byte> bytes = readFile(file);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  try {
    return parseJson(text, fmt::format("the file '{}'", file.string()));
  } catch (const JsonError& error) {
    badInput("{}:{}: {}", file.string(), error.line, error.what());
  }
}

void writeJson(const std::filesystem::path& file, const Json& json) {
  const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  writeFile(file, std::as_bytes(std::span(text)));
}

double numberIn(const Json& object, const char* key, double normal, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) return normal;
  if (!found->is_number() || !std::isfinite(found->get<double>()))
    badInput("{}: \"{}\" must be a finite number", where, key);
  return found->get<double>();
}

std::vector<double> numbersIn(const Json& object, const char* key, size_t count, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) badInput("{} has no \"{}\"", where, key);
  std::vector<double> numbers;
  append(*found, numbers, where, key);
  if (numbers.size() != count) badInput("{}: \"{}\" must be {} numbers, not {}", where, key, count, numbers.size());
  return numbers;
}

}  // namespace latelight::data
