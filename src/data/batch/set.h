// A data set's folder: what is in it, and who is at work there.
//
//   manifest.json                    the frames of the whole set, once it is done
//   .latelight/job.json, plan.json   what it is, and how many frames it has
//   .latelight/shard-0-of-3.jsonl    the frames that a shard has made (shard_log.h)
//   .latelight/log                   when and where: the only file that says so
#pragma once

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "data/batch/job.h"
#include "data/batch/manifest.h"
#include "data/batch/plan.h"
#include "data/batch/shard.h"

namespace latelight::data {

class SetFolder {
 public:
  explicit SetFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path manifest() const { return folder_ / "manifest.json"; }
  std::filesystem::path state() const { return folder_ / ".latelight"; }
  std::filesystem::path job() const { return state() / "job.json"; }
  std::filesystem::path plan() const { return state() / "plan.json"; }
  std::filesystem::path shard(const Shard& shard) const { return state() / ("shard-" + shard.name() + ".jsonl"); }
  std::vector<std::filesystem::path> shards() const;  // those that there are, by name

  // A line in the log, with the time and the machine. What goes wrong is ignored.
  void log(const std::string& line) const;

 private:
  std::filesystem::path folder_;
};

// Held by the process that makes a shard, or merges, as long as it lives.
class SetLock {
 public:
  // Throws Error(Usage) where another process holds it, unless it waits.
  explicit SetLock(const std::filesystem::path& manifest, bool wait = false);
  ~SetLock();
  SetLock(const SetLock&) = delete;
  SetLock& operator=(const SetLock&) = delete;

 private:
  int fd_ = -1;
};

// Makes the folder, and writes down the job. Throws Error(Usage) for a folder that is not empty: of something else, or,
// without `resume`, of a set that is not this job's other shards.
void openSet(const SetFolder& set, const Job& job, const Shard& shard, bool resume);

// What is there of a shard's frames, from any manifest in the folder: those that were made by the plan's settings, and
// whose files are there. The files of others are stale.
Manifest findFinished(const SetFolder& set, const Plan& plan, const Shard& shard);

// Of a set, from its folder alone.
struct SetStatus {
  uint64_t frames = 0;               // that it shall have
  Manifest manifest;                 // of the plan that it has now, from all shards
  std::set<std::string> otherFiles;  // of frames made by another plan
  uint64_t missing() const { return frames - std::min<uint64_t>(frames, manifest.frames.size()); }
};
// Throws Error(BadInput) where there is no set.
SetStatus readStatus(const SetFolder& set);

// Sentences about what is not as the manifests say; empty: every file is as it was written.
std::vector<std::string> verifySet(const SetFolder& set, const SetStatus& status);

// Joins the shards' manifests, writes the formats' files of the whole set, and removes stale files. Throws Error:
// SomeFramesFailed where frames are missing, unless they may be; Usage where a shard is still at work.
void mergeSet(const SetFolder& set, bool allowMissing);
// The same by a shard that has ended, if no frame is missing: the last one finishes the set.
void mergeIfComplete(const SetFolder& set);

}  // namespace latelight::data
