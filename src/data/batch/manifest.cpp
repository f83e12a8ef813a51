#include "data/batch/manifest.h"

#include <algorithm>
#include <charconv>
#include <chrono>

#include "base/error.h"
#include "base/files.h"
#include "base/hash.h"
#include "base/log.h"
#include "data/json_text.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

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
  if (!frame.drawn.is_null()) json["drawn"] = frame.drawn;
  json["entries"] = frame.entries;
  return json;
}

FinishedFrame frameIn(const Json& json) {
  FinishedFrame frame{.index = json.at("index").get<uint64_t>(), .settings = hashIn(json.at("settings"))};
  frame.name = json.at("name").get<std::string>();
  frame.scene = json.at("scene").get<std::string>();
  frame.camera = json.at("camera").get<std::string>();
  frame.variation = json.at("variation").get<uint32_t>();
  frame.drawn = json.value("drawn", Json());
  for (const Json& file : json.at("files")) frame.files.push_back(fileRecord(file));
  frame.entries = json.at("entries").get<std::vector<Json>>();
  return frame;
}

// `key`: a list, an element a line.
template <typename Range, typename Text>
void appendList(std::string& text, const char* key, const Range& range, const Text& textOf) {
  text += fmt::format("\"{}\": [", key);
  const char* before = "\n";
  for (const auto& element : range) {
    text += before + textOf(element);
    before = ",\n";
  }
  text += "]";
}

}  // namespace

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

Manifest readManifest(const std::filesystem::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  Manifest manifest;
  try {
    const Json json = parsed(bytes);
    manifest.plan = hashIn(json.at("plan"));
    for (const Json& frame : json.at("frames")) {
      FinishedFrame read = frameIn(frame);
      manifest.frames[read.index] = std::move(read);
    }
    for (const Json& file : json.at("files")) manifest.setFiles.push_back(fileRecord(file));
    for (const Json& failure : json.value("failed", Json::array()))
      manifest.failed[failure.at("name").get<std::string>()] = failure.at("reason").get<std::string>();
    manifest.stale = json.value("stale", std::set<std::string>());
  } catch (const Json::exception& error) {
    badInput("'{}' is not a manifest of a data set ({}): remove it, and render its frames again with --resume",
             path.string(), error.what());
  }
  return manifest;
}

void writeManifest(const std::filesystem::path& path, const Manifest& manifest) {
  std::string text = fmt::format("{{\"plan\": \"{}\",\n", hashText(manifest.plan));
  appendList(text, "files", manifest.setFiles, [](const FileRecord& file) { return dumped(describe(file)); });
  if (!manifest.failed.empty())
    appendList(text += ",\n", "failed", manifest.failed, [](const auto& failure) {
      return dumped({{"name", failure.first}, {"reason", failure.second}});
    });
  if (!manifest.stale.empty())
    appendList(text += ",\n", "stale", manifest.stale, [](const std::string& name) { return dumped(name); });
  appendList(text += ",\n", "frames", manifest.frames,
             [](const auto& frame) { return dumped(describe(frame.second)); });
  text += "}\n";
  writeFile(path, std::as_bytes(std::span(text)));
}

GrowingManifest::GrowingManifest(std::filesystem::path path, Manifest manifest)
    : path_(std::move(path)), manifest_(std::move(manifest)) {
  writeNow();
}

void GrowingManifest::finished(FinishedFrame frame) {
  const std::lock_guard lock(mutex_);
  manifest_.failed.erase(frame.name);
  for (const FileRecord& file : frame.files) manifest_.stale.erase(file.name);
  const uint64_t index = frame.index;
  manifest_.frames[index] = std::move(frame);
  if (now() < next_) return;
  try {
    writeNow();
  } catch (const Error&) {  // a full disk may have room later, and write() says so at the end
    next_ = now() + 1;
  }
}

void GrowingManifest::failed(const std::string& name, const std::string& why) {
  const std::lock_guard lock(mutex_);
  manifest_.failed[name] = why;
}

void GrowingManifest::write() {
  const std::lock_guard lock(mutex_);
  writeNow();
}

Manifest GrowingManifest::manifest() const {
  const std::lock_guard lock(mutex_);
  return manifest_;
}

void GrowingManifest::writeNow() {
  constexpr double kLeast = 0.5, kShare = 20;
  const double start = now();
  writeManifest(path_, manifest_);
  next_ = now() + std::max(kLeast, kShare * (now() - start));
}

}  // namespace latelight::data
