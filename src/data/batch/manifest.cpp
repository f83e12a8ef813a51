#include "data/batch/manifest.h"

#include <algorithm>
#include <charconv>
#include <unordered_set>

#include "base/error.h"
#include "base/files.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "data/json_text.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

// Appends the key and its list, one line per element. All threads convert elements to text, because there are many and
// formats may store much data per element.
template <typename Range>
void appendList(std::string& text, const char* key, const Range& range,
                Json (*describeOne)(const typename Range::value_type&)) {
  std::vector<const typename Range::value_type*> elements;
  for (const auto& element : range) elements.push_back(&element);
  std::vector<std::string> lines(elements.size());
  parallelFor(elements.size(), 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) lines[i] = dumped(describeOne(*elements[i]));
  });
  text += fmt::format("\"{}\": [", key);
  const char* before = "\n";
  for (const std::string& line : lines) {
    text += before + line;
    before = ",\n";
  }
  text += "]";
}

}  // namespace

uint64_t hashIn(const Json& json) {
  const std::string& text = json.get_ref<const std::string&>();
  uint64_t hash = 0;
  std::from_chars(text.data(), text.data() + text.size(), hash, 16);
  return hash;
}

Json describe(const FinishedFrame& frame) {
  Json files = Json::array();
  for (const FileRecord& file : frame.files) files.push_back(describe(file));
  Json json{{"index", frame.index},     {"name", frame.name},           {"scene", frame.scene},
            {"camera", frame.camera},   {"variation", frame.variation}, {"settings", hashText(frame.settings)},
            {"files", std::move(files)}};
  if (!frame.member.empty()) json["member"] = frame.member;
  if (!frame.archives.empty()) json["archives"] = Json::array();
  for (const FileRecord& archive : frame.archives) json["archives"].push_back(describe(archive));
  if (!frame.drawn.is_null()) json["drawn"] = frame.drawn;
  if (!frame.motion.is_null()) json["motion"] = frame.motion;
  json["entries"] = frame.entries;
  return json;
}

FinishedFrame finishedFrame(Json&& json) {
  FinishedFrame frame{.index = json.at("index").get<uint64_t>(), .settings = hashIn(json.at("settings"))};
  frame.name = json.at("name").get<std::string>();
  frame.scene = json.at("scene").get<std::string>();
  frame.camera = json.at("camera").get<std::string>();
  frame.variation = json.at("variation").get<uint32_t>();
  frame.member = json.value("member", "");
  if (json.contains("drawn")) frame.drawn = std::move(json["drawn"]);
  if (json.contains("motion")) frame.motion = std::move(json["motion"]);
  for (const Json& file : json.at("files")) frame.files.push_back(fileRecord(file));
  for (const Json& archive : json.value("archives", Json::array())) frame.archives.push_back(fileRecord(archive));
  // Sets of earlier versions have a record per format of a shared file.
  removeRepeated(frame.files);
  removeRepeated(frame.archives);
  frame.entries = std::move(json.at("entries").get_ref<Json::array_t&>());
  return frame;
}

Json describe(const FailedFrame& frame) {
  return {{"name", frame.first}, {"reason", frame.second}};
}

FailedFrame failedFrame(const Json& json) {
  return {json.at("name").get<std::string>(), json.at("reason").get<std::string>()};
}

void badManifest(const std::filesystem::path& path, const std::string& reason) {
  badInput("'{}' is not a manifest of a data set ({}): remove it, and render its frames again with --resume",
           path.string(), reason);
}

Json describe(const FileRecord& file) {
  return {{"file", file.name}, {"bytes", file.bytes}, {"hash", hashText(file.hash)}};
}

FileRecord fileRecord(const Json& json) {
  return {json.at("file").get<std::string>(), json.at("bytes").get<uint64_t>(), hashIn(json.at("hash"))};
}

FileRecord recordOf(const std::filesystem::path& folder, const std::string& name) {
  const std::vector<std::byte> bytes = readFile(folder / name);
  return {name, bytes.size(), hash64(bytes.data(), bytes.size())};
}

void removeRepeated(std::vector<FileRecord>& files) {
  std::unordered_set<std::string> names;
  std::erase_if(files, [&](const FileRecord& file) { return !names.insert(file.name).second; });
}

Manifest readManifest(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  Manifest manifest;
  try {
    Json json = parsed(bytes);
    manifest.plan = hashIn(json.at("plan"));
    for (Json& frame : json.at("frames")) {
      FinishedFrame read = finishedFrame(std::move(frame));
      manifest.frames[read.index] = std::move(read);
    }
    for (const Json& file : json.at("files")) manifest.setFiles.push_back(fileRecord(file));
    removeRepeated(manifest.setFiles);
    for (const Json& failure : json.value("failed", Json::array())) manifest.failed.insert(failedFrame(failure));
    manifest.stale = json.value("stale", std::set<std::string>());
  } catch (const Json::exception& error) {
    badManifest(path, reasonOf(error));
  }
  return manifest;
}

void writeManifest(const std::filesystem::path& path, const Manifest& manifest) {
  std::string text = fmt::format("{{\"plan\": \"{}\",\n", hashText(manifest.plan));
  appendList(text, "files", manifest.setFiles, describe);
  if (!manifest.failed.empty()) appendList(text += ",\n", "failed", manifest.failed, describe);
  if (!manifest.stale.empty())
    appendList(
        text += ",\n", "stale", manifest.stale, +[](const std::string& name) { return Json(name); });
  appendList(
      text += ",\n", "frames", manifest.frames,
      +[](const std::pair<const uint64_t, FinishedFrame>& frame) { return describe(frame.second); });
  text += "}\n";
  writeFile(path, std::as_bytes(std::span(text)));
}

}  // namespace latelight::data
