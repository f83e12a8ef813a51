// Builds a JSON document from events, in time and memory that grow only with the length of its text: objects are
// filled without a search for each key, and memory is claimed before it is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/memory.h"

namespace latelight::data {

// A document together with the memory that it uses.
struct JsonDocument {
  nlohmann::ordered_json json;
  // By path, for the document's first two levels only: "options.exposure", "scenes[1]". Deeper ones could take many
  // times the memory of the text.
  std::map<std::string, int> lines;
  std::shared_ptr<MemoryClaim> memory = std::make_shared<MemoryClaim>();
};

// What is wrong with a text, and on which line.
class JsonError : public std::runtime_error {
 public:
  JsonError(int line, const std::string& what) : std::runtime_error(what), line(line) {}
  const int line;
};

// The part of a text that is one value; copies of it cost as much again.
struct JsonSize {
  uint64_t values = 0, bytes = 0;
};

// Events must be nested properly. Every `line` counts from 1. Throws JsonError for a key that an object has twice, for
// nesting that is too deep, and for aliases that repeat too much; Error(DeviceLost) where there is no memory.
class JsonBuilder {
 public:
  // `what` names the document in messages about memory, as in "the job 'hall.yaml'".
  explicit JsonBuilder(std::string what) : what_(std::move(what)) {}

  void value(nlohmann::ordered_json value, int line);
  void startObject(int line) { start(nlohmann::ordered_json::object(), line); }
  void startArray(int line) { start(nlohmann::ordered_json::array(), line); }
  void key(std::string key, int line);
  void end();  // of the innermost object or array

  // A second copy of a value that is complete. The text's length bounds how much copies may add in all.
  void copy(const nlohmann::ordered_json& value, JsonSize size, uint64_t textBytes, int line);

  bool expectsKey() const { return !stack_.empty() && stack_.back().value->is_object() && !stack_.back().hasKey; }
  JsonSize size() const { return size_; }                        // of all values so far
  const nlohmann::ordered_json& last() const { return *last_; }  // the value that was completed last
  JsonDocument take();

 private:
  struct Level {
    nlohmann::ordered_json* value;
    std::vector<int> keyLines;  // objects only
    bool hasKey = false;        // a key waits for its value
    std::string path;           // of the document's first two levels
  };
  using Object = std::vector<std::pair<const std::string, nlohmann::ordered_json>>;

  nlohmann::ordered_json* place(nlohmann::ordered_json&& value, int line);
  void start(nlohmann::ordered_json container, int line);
  void claim(uint64_t bytes);
  void checkKeys(const Level& level) const;
  static Object& membersOf(nlohmann::ordered_json& object);

  std::string what_;
  JsonDocument document_;
  std::vector<Level> stack_;
  nlohmann::ordered_json* last_ = nullptr;
  JsonSize size_;
  uint64_t claimed_ = 0, copied_ = 0;
};

// Strict JSON, of any origin. Throws JsonError and Error as JsonBuilder does.
JsonDocument parseJson(std::string_view text, const std::string& what);

}  // namespace latelight::data
