// A data set's folder: its files, and the locks of the processes that work in it.
//
//   manifest.json                    the frames of the whole set, after it is complete
//   .latelight/job.json, plan.json   the job and the plan, with the number of frames
//   .latelight/shard-0-of-3.jsonl    the frames that a shard has rendered (shard_log.h)
//   .latelight/log                   times and machines; no other file records them
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
  std::filesystem::path lock(const Shard& shard) const { return this->shard(shard).replace_extension(".lock"); }
  std::filesystem::path partsLock() const { return state() / "parts.lock"; }
  std::vector<std::filesystem::path> shards() const;  // existing shard logs, sorted by name

  // Appends a line to the log, with the time and the machine. Errors are ignored.
  void log(const std::string& line) const;

 private:
  std::filesystem::path folder_;
};

// A lock file. A process holds it while it renders a shard or merges the set.
class SetLock {
 public:
  // If another process holds the lock, waits for it if `wait` is true, and otherwise throws Error(Usage).
  explicit SetLock(const std::filesystem::path& manifest, bool wait = false);
  ~SetLock();
  SetLock(const SetLock&) = delete;
  SetLock& operator=(const SetLock&) = delete;

 private:
  int fd_ = -1;
};

// Throws Error(Usage) if the set is a file, or if its folder contains files of anything but a data set. Without
// `resume`, also throws if it contains a data set, unless only other shards of this job have written to it; with
// `resume`, if the set has a link that leads out of its folder. Also throws if the folder cannot be created or written.
void checkSet(const SetFolder& set, const Job& job, const Shard& shard, bool resume);

// Creates the folder after checkSet(). Returns true if it created the set.
bool openSet(const SetFolder& set, const Job& job, const Shard& shard, bool resume);

// Removes a set that openSet() created and that holds nothing but the locks of this shard, which the caller holds.
void removeNewSet(const SetFolder& set, const Shard& shard);

// Replaces the job's document and the plan. Call it after the job was accepted and its plan made: formats write the
// files of the whole set by this document.
void saveJob(const SetFolder& set, const Job& job, const Plan& plan);

// Collects the finished frames of a shard from all manifests in the folder: frames whose settings hash matches the plan
// and whose files exist, and were not replaced by a run of another job. The files of the shard's other frames are
// stale, as are those of other shards' frames that the shard will replace.
Manifest findFinished(const SetFolder& set, const Job& job, const Plan& plan, const Shard& shard);

// The state of a set, determined only from its folder.
struct SetStatus {
  uint64_t frames = 0;                           // planned number of frames
  Manifest manifest;                             // frames of the current plan, from all shards
  std::set<std::string> otherFiles;              // files of frames that another plan rendered
  std::vector<std::filesystem::path> otherLogs;  // shard logs of other plans
  bool isMerged = false;  // manifest.json is of the current plan, and no shard has written a log since
  uint64_t missing() const { return frames - std::min<uint64_t>(frames, manifest.frames.size()); }
};
// Throws Error(BadInput) if the folder contains no set.
SetStatus readStatus(const SetFolder& set);

// Compares all files with the manifests. Returns one sentence per missing or changed file, and per link that leads out
// of the folder; empty if there is none.
std::vector<std::string> verifySet(const SetFolder& set, const SetStatus& status);

// Merges the shards' manifests, writes the formats' files of the whole set, and removes stale files. Throws
// Error(SomeFramesFailed) if frames are missing and `allowMissing` is false, and Error(Usage) if a shard is still
// running or a link leads out of the folder.
void mergeSet(const SetFolder& set, bool allowMissing);
// Merges the set if no frame is missing. Every shard calls it at its end, so the last one completes the set.
void mergeIfComplete(const SetFolder& set);

}  // namespace latelight::data
