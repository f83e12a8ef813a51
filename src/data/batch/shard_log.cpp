#include "data/batch/shard_log.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <string_view>

#include "base/error.h"
#include "base/files.h"
#include "base/parallel.h"
#include "base/text.h"
#include "base/write.h"
#include "data/json_text.h"

namespace latelight::data {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

struct Line {
  Json json;
  std::optional<FinishedFrame> frame;
  std::string error;  // why it cannot be read
};

std::vector<std::string_view> wholeLines(std::string_view text) {
  std::vector<std::string_view> lines;
  for (size_t end; (end = text.find('\n')) != text.npos; text.remove_prefix(end + 1))
    lines.push_back(text.substr(0, end));
  return lines;
}

// Returns the library's reason. Its line is that of the text of one line, and always 1.
std::string reasonInLine(const Json::exception& error) {
  std::string reason = reasonOf(error);
  replaceAll(reason, "at line 1, column", "at column");
  return reason;
}

Line readLine(std::string_view text) {
  Line line;
  try {
    line.json = Json::parse(text);
    if (!line.json.contains("frame")) return line;
    line.frame = finishedFrame(std::move(line.json["frame"]));
    line.json = Json::object();
  } catch (const Json::exception& error) {
    line.error = reasonInLine(error);
  }
  return line;
}

std::vector<Line> readLines(const std::vector<std::string_view>& texts) {
  std::vector<Line> lines(texts.size());
  parallelFor(texts.size(), 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) lines[i] = readLine(texts[i]);
  });
  return lines;
}

void take(Line line, Manifest& manifest) {
  if (line.frame) {
    manifest.failed.erase(line.frame->name);
    for (const FileRecord& file : line.frame->files) manifest.stale.erase(file.name);
    const uint64_t index = line.frame->index;
    manifest.frames.insert_or_assign(index, *std::move(line.frame));
  } else if (line.json.contains("failed")) {
    const FailedFrame failure = failedFrame(line.json["failed"]);
    manifest.failed[failure.first] = failure.second;
  } else if (line.json.contains("stale")) {
    manifest.stale = line.json["stale"].get<std::set<std::string>>();
  } else {
    manifest.plan = hashIn(line.json.at("plan"));
  }
}

std::string lineOf(const char* key, Json value) {
  return dumped(Json{{key, std::move(value)}}) + "\n";
}

std::string textOf(const Manifest& manifest) {
  std::string text = lineOf("plan", hashText(manifest.plan));
  if (!manifest.stale.empty()) text += lineOf("stale", manifest.stale);
  for (const auto& [index, frame] : manifest.frames) text += lineOf("frame", data::describe(frame));
  for (const auto& failure : manifest.failed) text += lineOf("failed", data::describe(failure));
  return text;
}

}  // namespace

Manifest readShardLog(const fs::path& path) {
  const std::vector<std::byte> bytes = readFile(path);
  Manifest manifest;
  std::vector<Line> lines = readLines(wholeLines({reinterpret_cast<const char*>(bytes.data()), bytes.size()}));
  for (size_t i = 0; i < lines.size(); ++i) {
    std::string error = lines[i].error;
    try {
      if (error.empty()) take(std::move(lines[i]), manifest);
    } catch (const Json::exception& wrong) {
      error = reasonInLine(wrong);
    }
    if (!error.empty()) badManifest(path, fmt::format("line {}: {}", i + 1, error));
  }
  return manifest;
}

ShardLog::ShardLog(const fs::path& path, const Manifest& found) : path_(path), failed_(found.failed) {
  for (const auto& [index, frame] : found.frames) frames_.insert(index);
  const std::string text = textOf(found);
  writeFile(path, std::as_bytes(std::span(text)));
  size_ = static_cast<int64_t>(text.size());
  fd_ = open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (fd_ < 0) failToWrite(path, errno);
}

ShardLog::~ShardLog() {
  if (fd_ >= 0) close(fd_);
}

void ShardLog::finished(const FinishedFrame& frame) {
  const std::string line = lineOf("frame", data::describe(frame));
  const std::lock_guard lock(mutex_);
  waiting_.reserve(waiting_.size() + line.size());  // memory that runs out changes nothing: the frame failed
  frames_.insert(frame.index);
  failed_.erase(frame.name);
  add(line);
}

void ShardLog::failed(const std::string& name, const std::string& why) {
  const std::lock_guard lock(mutex_);
  failed_[name] = why;
  add(lineOf("failed", data::describe(FailedFrame{name, why})));
}

void ShardLog::end() {
  const std::lock_guard lock(mutex_);
  if (const int error = append()) failToWrite(path_, error);
}

uint64_t ShardLog::frames() const {
  const std::lock_guard lock(mutex_);
  return frames_.size();
}

std::map<std::string, std::string> ShardLog::whyFailed() const {
  const std::lock_guard lock(mutex_);
  return failed_;
}

void ShardLog::add(const std::string& line) {
  waiting_ += line;
  append();
}

int ShardLog::append() {
  if (const int error = writeAll(fd_, std::as_bytes(std::span(waiting_)))) {
    // Remove the partial line, so that the next line does not begin after it.
    return ftruncate(fd_, size_) == 0 ? error : errno;
  }
  size_ += static_cast<int64_t>(waiting_.size());
  waiting_.clear();
  return 0;
}

}  // namespace latelight::data
