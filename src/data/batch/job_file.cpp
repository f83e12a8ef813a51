#include "data/batch/job_file.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <optional>
#include <set>

#include "base/error.h"
#include "base/files.h"
#include "base/text.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr size_t kMostNodes = 10'000'000;  // aliases of YAML repeat what they name
constexpr int kMostDepth = 64;

// YAML to JSON by the rules of YAML 1.2's core schema: plain words may be numbers, quoted ones are texts.
class YamlReader {
 public:
  explicit YamlReader(JobDocument& job) : job_(job) {}

  Json read(const YAML::Node& node, const std::string& path, int depth = 0) {
    if (depth > kMostDepth || ++nodes_ > kMostNodes) badUsage("{}: it is nested too deeply, or too large", job_.name);
    job_.lines.try_emplace(path, node.Mark().line + 1);
    if (node.IsMap()) return readMap(node, path, depth);
    if (node.IsSequence()) {
      Json list = Json::array();
      for (size_t i = 0; i < node.size(); ++i) list.push_back(read(node[i], fmt::format("{}[{}]", path, i), depth + 1));
      return list;
    }
    return node.IsScalar() ? scalar(node) : Json();
  }

 private:
  Json readMap(const YAML::Node& node, const std::string& path, int depth) {
    Json map = Json::object();
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) badUsage("{}:{}: a key is a text", job_.name, entry.first.Mark().line + 1);
      const std::string& key = entry.first.Scalar();
      const std::string below = path.empty() ? key : path + "." + key;
      const int line = entry.first.Mark().line + 1;
      if (map.contains(key)) badUsage("{}:{}: the key {} is there twice", job_.name, line, below);
      job_.lines[below] = line;
      map[key] = read(entry.second, below, depth + 1);
    }
    return map;
  }

  static Json scalar(const YAML::Node& node) {
    const std::string& text = node.Scalar();
    if (node.Tag() == "!" || node.Tag() == "tag:yaml.org,2002:str") return text;
    if (text == "null" || text == "~" || text.empty()) return nullptr;
    if (text == "true" || text == "false") return text == "true";
    const std::string_view digits = text.starts_with('+') ? std::string_view(text).substr(1) : std::string_view(text);
    if (const auto whole = parseNumber<int64_t>(digits)) return *whole;
    if (const auto whole = parseNumber<uint64_t>(digits)) return *whole;
    if (const auto number = parseNumber<double>(digits)) return *number;
    return text;
  }

  JobDocument& job_;
  size_t nodes_ = 0;
};

int lineOf(const std::string& text, size_t byte) {
  return 1 + static_cast<int>(
                 std::count(text.begin(), text.begin() + static_cast<long>(std::min(byte, text.size())), '\n'));
}

// Strictly JSON; YAML, which JSON is a part of, knows its lines.
void readJson(JobDocument& job, const std::string& text) {
  const auto limit = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > kMostDepth) badUsage("{}: it is nested too deeply", job.name);
    return true;
  };
  try {
    job.json = Json::parse(text, limit);
  } catch (const Json::parse_error& error) {
    const std::string what = error.what();
    const size_t detail = what.rfind(" - ");
    badUsage("{}:{}: it is not JSON: {}", job.name, lineOf(text, error.byte),
             detail == std::string::npos ? "the file ends, or a value is not closed" : what.substr(detail + 3));
  }
  try {
    YamlReader(job).read(YAML::Load(text), "");
  } catch (const YAML::Exception&) {  // texts that YAML writes otherwise: messages then have no line
  }
}

void readYaml(JobDocument& job, const std::string& text) {
  try {
    job.json = YamlReader(job).read(YAML::Load(text), "");
  } catch (const YAML::Exception& error) {
    badUsage("{}:{}: it is not YAML: {}", job.name, error.mark.line + 1, error.msg);
  }
}

}  // namespace

std::string JobDocument::place(const std::string& path) const {
  if (name.empty()) return path.empty() ? "the job" : path;
  const auto line = lines.find(path);
  const std::string at = line == lines.end() ? name : fmt::format("{}:{}", name, line->second);
  return path.empty() ? at : at + ": " + path;
}

JobDocument readJobFile(const std::filesystem::path& path) {
  JobDocument job{.name = path.string()};
  const std::string ending = path.extension().string();
  if (ending != ".json" && ending != ".yaml" && ending != ".yml")
    badUsage("the job \"{}\" does not end in a language; end it in .json, .yaml or .yml", job.name);
  const std::vector<std::byte> bytes = readFile(path);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  ending == ".json" ? readJson(job, text) : readYaml(job, text);
  return job;
}

}  // namespace latelight::data
