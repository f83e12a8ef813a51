#include "data/batch/job_file.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <sstream>
#include <unordered_map>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "base/lowercase.h"
#include "base/text.h"
#include "data/json_builder.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

// Converts YAML to JSON by the core schema of YAML 1.2: plain scalars may be numbers, quoted scalars are strings. The
// nodes of yaml-cpp are not used: they require hundreds of bytes each, and aliases could multiply them without limit.
class YamlEvents : public YAML::EventHandler {
 public:
  YamlEvents(JsonBuilder& builder, uint64_t textBytes) : builder_(builder), textBytes_(textBytes) {}

  void OnDocumentStart(const YAML::Mark& mark) override { begin_ = mark; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override { add(Json(), mark, anchor); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    if (builder_.expectsKey())
      builder_.key(text, lineOf(mark));
    else
      add(scalar(tag, text), mark, anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    rejectKey(mark);
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) throw JsonError(lineOf(mark), "an alias stands within what it names");
    builder_.copy(found->second.value, found->second.size, textBytes_, lineOf(mark));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    rejectKey(mark);
    open_.push_back({anchor, builder_.size()});
    builder_.startArray(lineOf(mark));
  }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    rejectKey(mark);
    open_.push_back({anchor, builder_.size()});
    builder_.startObject(lineOf(mark));
  }
  void OnSequenceEnd() override {
    builder_.end();
    remember(open_.back().anchor, open_.back().before);
    open_.pop_back();
  }
  void OnMapEnd() override { OnSequenceEnd(); }

  int firstLine() const { return lineOf(begin_); }   // the document's first line
  int firstCharacter() const { return begin_.pos; }  // its index in the text

 private:
  struct Open {
    YAML::anchor_t anchor;
    JsonSize before;
  };
  struct Anchor {
    Json value;
    JsonSize size;
  };

  static int lineOf(const YAML::Mark& mark) { return std::max(mark.line, 0) + 1; }

  void rejectKey(const YAML::Mark& mark) const {
    if (builder_.expectsKey()) throw JsonError(lineOf(mark), "a key is a text");
  }

  void add(Json value, const YAML::Mark& mark, YAML::anchor_t anchor) {
    rejectKey(mark);
    const JsonSize before = builder_.size();
    builder_.value(std::move(value), lineOf(mark));
    remember(anchor, before);
  }

  // Stores the value of an anchor for its aliases. The stored copy's memory is claimed like a copy in the document.
  void remember(YAML::anchor_t anchor, JsonSize before) {
    if (anchor == 0) return;
    const JsonSize all = builder_.size(), size{all.values - before.values, all.bytes - before.bytes};
    memory_.grow(size.bytes, "the anchors of a job");
    anchors_[anchor] = {builder_.last(), size};
  }

  static Json scalar(const std::string& tag, const std::string& text) {
    if (tag == "!" || tag == "tag:yaml.org,2002:str") return text;
    if (text == "null" || text == "~" || text.empty()) return nullptr;
    if (text == "true" || text == "false") return text == "true";
    const std::string_view digits = text.starts_with('+') ? std::string_view(text).substr(1) : std::string_view(text);
    if (const auto whole = parseNumber<int64_t>(digits)) return *whole;
    if (const auto whole = parseNumber<uint64_t>(digits)) return *whole;
    if (const auto number = parseNumber<double>(digits)) return *number;
    return text;
  }

  JsonBuilder& builder_;
  uint64_t textBytes_;
  std::vector<Open> open_;
  std::unordered_map<YAML::anchor_t, Anchor> anchors_;
  MemoryClaim memory_;
  YAML::Mark begin_ = YAML::Mark::null_mark();
};

// Claims memory for the tokens of yaml-cpp, which stores all tokens of a line until it knows if the line begins with a
// key.
MemoryClaim claimTokens(const std::string& text) {
  constexpr uint64_t kTokenBytes = 128;
  uint64_t longest = 0;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    longest = std::max<uint64_t>(longest, end - begin);
    begin = end + 1;
  }
  return {longest / 2 * kTokenBytes + 2 * text.size(), "the job's longest line"};
}

JsonDocument readYaml(const std::string& text, const std::string& what) {
  const MemoryClaim tokens = claimTokens(text);
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  JsonBuilder builder(what);
  YamlEvents events(builder, text.size());
  try {
    if (!parser.HandleNextDocument(events)) return {};
    for (int before = events.firstCharacter();;) {
      JsonBuilder other(what);
      YamlEvents others(other, text.size());
      if (!parser.HandleNextDocument(others)) break;
      if (!other.take().json.is_null())
        throw JsonError(others.firstLine(), "a second document begins: a job is one, so put it into a file of its own");
      // yaml-cpp does not skip characters that begin no value, such as ",", and finds empty documents there forever.
      if (others.firstCharacter() == std::exchange(before, others.firstCharacter()))
        throw JsonError(others.firstLine(), "it is not YAML: there is a character that begins no value");
    }
  } catch (const YAML::Exception& error) {
    throw JsonError(error.mark.line + 1, "it is not YAML: " + error.msg);
  }
  return builder.take();
}

}  // namespace

std::string JobDocument::place(const std::string& path) const {
  if (name.empty()) return path.empty() ? "the job" : path;
  std::string container = path;
  while (!container.empty() && !lines.contains(container)) {
    const size_t end = container.find_last_of(".[");
    container.resize(end == std::string::npos ? 0 : end);
  }
  const auto line = container.empty() && !path.empty() ? lines.end() : lines.find(container);
  if (line != lines.end() && line->second == 0) return path;
  const std::string at = line == lines.end() ? name : fmt::format("{}:{}", name, line->second);
  return path.empty() ? at : at + ": " + path;
}

std::string JobDocument::located(const std::string& message) const {
  const std::string path = message.substr(0, message.find_first_of(" :"));
  const std::string key = path.substr(0, path.find_first_of(".["));
  if (key == "cameras" || key == "variations")
    return lines.contains(key) ? place(path) + message.substr(path.size()) : message;
  if (const std::string option = optionIn(message); !option.empty()) return place(option) + ": " + message;
  return message;
}

// Returns the path of the first option that the message names and the file sets; empty if there is none.
std::string JobDocument::optionIn(const std::string& message) const {
  for (size_t at = message.find("--"); at != std::string::npos; at = message.find("--", at)) {
    at += 2;
    const size_t end = message.find_first_not_of("abcdefghijklmnopqrstuvwxyz-", at);
    const std::string option = "options." + message.substr(at, end - at);
    if (const auto line = lines.find(option); line != lines.end() && line->second > 0) return option;
  }
  return "";
}

void JobDocument::forgetLines(const std::string& path) {
  std::erase_if(lines, [&](const auto& line) {
    const std::string& known = line.first;
    return known.starts_with(path) &&
           (known.size() == path.size() || known[path.size()] == '.' || known[path.size()] == '[');
  });
  lines[path] = 0;
}

JobDocument readJobFile(const std::filesystem::path& path) {
  JobDocument job{.name = path.string()};
  const std::string ending = lowercaseExtension(path);
  if (ending != ".json" && ending != ".yaml" && ending != ".yml")
    badUsage("the job \"{}\" does not end in a language; end it in .json, .yaml or .yml", job.name);
  const std::vector<std::byte> bytes = readFile(path);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string what = fmt::format("the job '{}'", job.name);
  try {
    JsonDocument document = ending == ".json" ? parseJson(text, what) : readYaml(text, what);
    job.json = std::move(document.json);
    job.lines = std::move(document.lines);
    job.memory = std::move(document.memory);
  } catch (const JsonError& error) {
    badUsage("{}:{}: {}", job.name, error.line, error.what());
  }
  return job;
}

}  // namespace latelight::data
