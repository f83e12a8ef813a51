// What a data set says of its frames: a log a shard while it is made (shard_log.h), and a manifest of all once it is
// done. It holds nothing of the time or the machine, and frames by their index, so that a set has the same bytes
// however it was made.
#pragma once

#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace latelight::data {

struct FileRecord {
  std::string name;  // relative to the data set's folder
  uint64_t bytes = 0, hash = 0;
};
nlohmann::ordered_json describe(const FileRecord& file);
FileRecord fileRecord(const nlohmann::ordered_json& json);
// As the file is now. Throws Error(BadInput) where it can't be read.
FileRecord recordOf(const std::filesystem::path& folder, const std::string& name);

// A finished frame.
struct FinishedFrame {
  uint64_t index = 0, settings = 0;  // Plan::settings()
  std::string name, scene, camera;
  uint32_t variation = 0;
  nlohmann::ordered_json drawn;   // what the variation drew
  nlohmann::ordered_json motion;  // the frames that the output motion leads to; null: the job does not ask for it
  std::vector<FileRecord> files;
  std::vector<nlohmann::ordered_json> entries;  // of each format, for its files of the whole set
};

// Its name, and why.
using FailedFrame = std::pair<const std::string, std::string>;

nlohmann::ordered_json describe(const FinishedFrame& frame);
nlohmann::ordered_json describe(const FailedFrame& frame);
// And back; throw nlohmann's exceptions where the JSON is no such thing.
FinishedFrame finishedFrame(nlohmann::ordered_json&& json);
FailedFrame failedFrame(const nlohmann::ordered_json& json);
uint64_t hashIn(const nlohmann::ordered_json& json);

struct Manifest {
  uint64_t plan = 0;  // Plan::hash() that it was made by
  std::map<uint64_t, FinishedFrame> frames;
  std::map<std::string, std::string> failed;  // frames and scenes that could not be made, by name, and why
  std::set<std::string> stale;                // files of frames that the job no longer has so: removed when it is done
  std::vector<FileRecord> setFiles;           // of the whole set
};

[[noreturn]] void badManifest(const std::filesystem::path& path, const std::exception& error);

// Throws Error(BadInput) that names the file where it is no manifest.
Manifest readManifest(const std::filesystem::path& path);

// Whole or not at all. Throws Error(Usage) where it can't be written.
void writeManifest(const std::filesystem::path& path, const Manifest& manifest);

}  // namespace latelight::data
