// The records of a data set's frames: one log per shard while the set is rendered (shard_log.h), and one manifest of
// all frames after it is complete. The manifest contains no times or machine names and lists frames by index, so a set
// has the same bytes for any number of shards, devices and runs.
#pragma once

#include <cstdint>
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
// Returns the record of a file in its present state. Throws Error(BadInput) if the file cannot be read.
FileRecord recordOf(const std::filesystem::path& folder, const std::string& name);
// Keeps only the first record of each file, in their order: formats may share a file, and each of them names it.
void removeRepeated(std::vector<FileRecord>& files);

// A finished frame.
struct FinishedFrame {
  uint64_t index = 0, settings = 0;  // Plan::settings()
  std::string name, scene, camera;
  std::string member;  // of a pair or rig, as in JobCamera; empty: the camera belongs to none
  uint32_t variation = 0;
  nlohmann::ordered_json drawn;   // the values that the variation drew; null: none
  nlohmann::ordered_json motion;  // neighbors that the output motion refers to; null if the job has no such output
  std::vector<FileRecord> files;
  std::vector<FileRecord> archives;             // files of the whole set that hold files of this frame
  std::vector<nlohmann::ordered_json> entries;  // one per format, for its files of the whole set
};

// The name of a frame or scene, and the reason of its failure.
using FailedFrame = std::pair<const std::string, std::string>;

nlohmann::ordered_json describe(const FinishedFrame& frame);
nlohmann::ordered_json describe(const FailedFrame& frame);
// Convert JSON back; they throw nlohmann's exceptions if the JSON has another structure.
FinishedFrame finishedFrame(nlohmann::ordered_json&& json);
FailedFrame failedFrame(const nlohmann::ordered_json& json);
uint64_t hashIn(const nlohmann::ordered_json& json);

struct Manifest {
  uint64_t plan = 0;                          // Plan::hash() of the plan that its frames were rendered by
  std::map<uint64_t, FinishedFrame> frames;   // by index
  std::map<std::string, std::string> failed;  // reasons by name of the frame or scene
  std::set<std::string> stale;                // files that are not of the job's current frames; removed by the merge
  std::vector<FileRecord> setFiles;           // the formats' files of the whole set
};

// Throws Error(BadInput) that names the file.
[[noreturn]] void badManifest(const std::filesystem::path& path, const std::string& reason);

// Throws Error(BadInput) that names the file if it is not a manifest.
Manifest readManifest(const std::filesystem::path& path);

// Writes the file whole or not at all. Throws Error(Usage) if it cannot be written.
void writeManifest(const std::filesystem::path& path, const Manifest& manifest);

}  // namespace latelight::data
