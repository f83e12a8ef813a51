// Builds a JSON document from parser events, in time and memory that grow only with the length of its text: members are
// appended to objects without a search for each key, and memory is claimed before it is allocated.
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

// A document, its line numbers and the claim on the memory that it uses.
struct JsonDocument {
  nlohmann::ordered_json json;
  // Line numbers by path, such as "options.exposure" and "scenes[1]". Only the document's first two levels have them,
  // because deeper paths could require many times the memory of the text.
  std::map<std::string, int> lines;
  std::shared_ptr<MemoryClaim> memory = std::make_shared<MemoryClaim>();
};

// An error in a text, with its line.
class JsonError : public std::runtime_error {
 public:
  JsonError(int line, const std::string& what) : std::runtime_error(what), line(line) {}
  const int line;
};

// The number of values in a part of a document and the bytes of memory that they use. A copy uses as much memory again.
struct JsonSize {
  uint64_t values = 0, bytes = 0;
};

// Events must be properly nested. Every `line` counts from 1. Throws JsonError for duplicate keys of an object, for
// nesting that is too deep, and for aliases that copy too much. Throws Error(OutOfMemory) if memory runs out.
class JsonBuilder {
 public:
  // `what` names the document in messages about memory, such as "the job 'hall.yaml'".
  explicit JsonBuilder(std::string what) : what_(std::move(what)) {}

  void value(nlohmann::ordered_json value, int line);
  void startObject(int line) { start(nlohmann::ordered_json::object(), line); }
  void startArray(int line) { start(nlohmann::ordered_json::array(), line); }
  void key(std::string key, int line);
  void end();  // ends the innermost object or array

  // Adds a copy of a completed value of the given size. The length of the text, `textBytes`, limits how many values all
  // copies may add in total.
  void copy(const nlohmann::ordered_json& value, JsonSize size, uint64_t textBytes, int line);

  bool expectsKey() const { return !stack_.empty() && stack_.back().value->is_object() && !stack_.back().hasKey; }
  JsonSize size() const { return size_; }                        // size of all values so far
  const nlohmann::ordered_json& last() const { return *last_; }  // the most recently completed value
  JsonDocument take();

 private:
  struct Level {
    nlohmann::ordered_json* value;
    std::vector<int> keyLines;  // objects only
    bool hasKey = false;        // the last key has no value yet
    std::string path;           // set only in the document's first two levels
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

// Parses strict JSON. The text may be from an untrusted source. Throws JsonError and Error as JsonBuilder does.
JsonDocument parseJson(std::string_view text, const std::string& what);

}  // namespace latelight::data
