#include "data/json_builder.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr size_t kMaxDepth = 64;
constexpr size_t kPathLevels = 2;

// Estimates of memory, in bytes. Values and keys are in vectors whose capacity may be twice their length; kHeapBytes is
// the overhead of one heap allocation.
constexpr uint64_t kValueBytes = 2 * sizeof(Json);
constexpr uint64_t kKeyBytes = 2 * (sizeof(std::string) + sizeof(int));
constexpr uint64_t kHeapBytes = 48;

// The minimum step by which a claim grows, in bytes, because each step has a cost.
constexpr uint64_t kClaimStep = uint64_t{1} << 20;

// Aliases may add this many values in total: the larger of a fixed number and a number per byte of text.
constexpr uint64_t kCopiedValues = 100'000, kCopiedValuesPerByte = 16;

}  // namespace

JsonBuilder::Object& JsonBuilder::membersOf(Json& object) {
  return static_cast<Object&>(object.get_ref<Json::object_t&>());
}

void JsonBuilder::claim(uint64_t bytes) {
  size_.bytes += bytes;
  while (claimed_ < size_.bytes) {
    const uint64_t step = std::max(kClaimStep, size_.bytes - claimed_);
    document_.memory->grow(step, what_);
    claimed_ += step;
  }
}

Json* JsonBuilder::place(Json&& value, int line) {
  ++size_.values;
  claim(kValueBytes);
  if (stack_.empty()) {
    document_.json = std::move(value);
    document_.lines[""] = line;
    return &document_.json;
  }
  Level& level = stack_.back();
  if (level.value->is_object()) {
    level.hasKey = false;
    Json& member = membersOf(*level.value).back().second;
    member = std::move(value);
    return &member;
  }
  auto& list = level.value->get_ref<Json::array_t&>();
  if (stack_.size() <= kPathLevels) document_.lines[fmt::format("{}[{}]", level.path, list.size())] = line;
  return &list.emplace_back(std::move(value));
}

void JsonBuilder::value(Json value, int line) {
  if (value.is_string()) claim(kHeapBytes + sizeof(std::string) + value.get_ref<const std::string&>().size());
  last_ = place(std::move(value), line);
}

void JsonBuilder::start(Json container, int line) {
  if (stack_.size() >= kMaxDepth) throw JsonError(line, fmt::format("it is nested deeper than {} levels", kMaxDepth));
  claim(2 * kHeapBytes);
  Level level;
  if (!stack_.empty() && stack_.size() <= kPathLevels) {
    const Level& above = stack_.back();
    level.path = above.value->is_object() ? membersOf(*above.value).back().first : std::to_string(above.value->size());
    if (above.value->is_array())
      level.path = fmt::format("{}[{}]", above.path, level.path);
    else if (!above.path.empty())
      level.path = above.path + "." + level.path;
  }
  level.value = place(std::move(container), line);
  stack_.push_back(std::move(level));
}

void JsonBuilder::key(std::string key, int line) {
  Level& level = stack_.back();
  claim(kKeyBytes + kHeapBytes + key.size());
  if (stack_.size() <= kPathLevels) {
    claim(2 * kHeapBytes + level.path.size() + key.size());
    document_.lines.try_emplace(level.path.empty() ? key : level.path + "." + key, line);
  }
  membersOf(*level.value).emplace_back(std::move(key), Json());
  level.keyLines.push_back(line);
  level.hasKey = true;
}

void JsonBuilder::checkKeys(const Level& level) const {
  const Object& members = membersOf(*level.value);
  std::vector<uint32_t> order(members.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, [&](uint32_t a, uint32_t b) {
    const int compared = members[a].first.compare(members[b].first);
    return compared != 0 ? compared < 0 : a < b;
  });
  for (size_t i = 1; i < order.size(); ++i)
    if (members[order[i]].first == members[order[i - 1]].first)
      throw JsonError(level.keyLines[order[i]],
                      fmt::format("the key {} is there twice", shortened(members[order[i]].first)));
}

void JsonBuilder::end() {
  if (stack_.back().value->is_object()) checkKeys(stack_.back());
  last_ = stack_.back().value;
  stack_.pop_back();
}

void JsonBuilder::copy(const Json& value, JsonSize size, uint64_t textBytes, int line) {
  copied_ += size.values;
  if (copied_ > std::max(kCopiedValues, kCopiedValuesPerByte * textBytes))
    throw JsonError(line, "its aliases repeat too much: write out what they stand for");
  size_.values += size.values;
  claim(size.bytes);
  last_ = place(Json(value), line);
}

JsonDocument JsonBuilder::take() {
  return std::move(document_);
}

namespace {

// An input iterator over the characters of a text that counts the characters read.
struct Position {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  const char* at;
  size_t* read;

  const char& operator*() const { return *at; }
  Position& operator++() {
    ++at;
    ++*read;
    return *this;
  }
  bool operator==(const Position& other) const { return at == other.at; }
  bool operator!=(const Position& other) const { return at != other.at; }
};

class Events : public nlohmann::json_sax<Json> {
 public:
  Events(std::string_view text, JsonBuilder& builder) : text_(text), builder_(builder) {}

  Position begin() { return {text_.data(), &read_}; }
  Position end() { return {text_.data() + text_.size(), &read_}; }

  bool null() override { return add(Json()); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override { return add(std::move(value)); }
  bool binary(binary_t&) override { return false; }
  bool start_object(size_t) override {
    builder_.startObject(line());
    return true;
  }
  bool key(string_t& key) override {
    builder_.key(std::move(key), line());
    return true;
  }
  bool start_array(size_t) override {
    builder_.startArray(line());
    return true;
  }
  bool end_object() override { return end_array(); }
  bool end_array() override {
    builder_.end();
    return true;
  }
  bool parse_error(size_t, const std::string&, const Json::exception& error) override {
    if (error.id == 406) throw JsonError(line(), "it has a number that is too large");
    const std::string what = error.what();
    const size_t detail = what.rfind(" - ");
    throw JsonError(line(),
                    "it is not JSON: " + (detail == std::string::npos ? "the file ends, or a value is not closed"
                                                                      : what.substr(detail + 3)));
  }

 private:
  bool add(Json value) {
    builder_.value(std::move(value), line());
    return true;
  }

  // Returns the line where the current token ends. The last character read is excluded, because it may be the character
  // that follows a number.
  int line() {
    const size_t end = read_ > 0 ? read_ - 1 : 0;
    line_ += static_cast<int>(std::count(text_.data() + counted_, text_.data() + std::max(counted_, end), '\n'));
    counted_ = std::max(counted_, end);
    return line_;
  }

  std::string_view text_;
  JsonBuilder& builder_;
  size_t read_ = 0, counted_ = 0;
  int line_ = 1;
};

}  // namespace

JsonDocument parseJson(std::string_view text, const std::string& what) {
  JsonBuilder builder(what);
  Events events(text, builder);
  Json::sax_parse(events.begin(), events.end(), &events);
  return builder.take();
}

}  // namespace latelight::data
