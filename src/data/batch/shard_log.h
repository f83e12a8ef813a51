// The append-only log of a shard's frames. A line is written when a frame is finished, so a killed process loses no
// finished frame, and the cost of a frame does not grow with the number of frames.
//
//   {"plan": "0123456789abcdef"}
//   {"stale": ["FILE", ...]}
//   {"frame": {...}}                           as in the manifest
//   {"failed": {"name": ..., "reason": ...}}   until a later line lists the frame as finished
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <string>

#include "data/batch/manifest.h"

namespace latelight::data {

// Reads a log into a manifest. A last line without a line break is ignored, because the process was killed while
// writing it. Throws Error(BadInput) that names the file if it is not a log.
Manifest readShardLog(const std::filesystem::path& path);

class ShardLog {
 public:
  // Replaces the log by one that contains `found`. Throws Error(Usage) if it cannot be written.
  ShardLog(const std::filesystem::path& path, const Manifest& found);
  ~ShardLog();
  ShardLog(const ShardLog&) = delete;
  ShardLog& operator=(const ShardLog&) = delete;

  // Record a frame, from any thread. Lines that cannot be written, for example because the disk is full, are retried
  // with the next line and by end().
  void finished(const FinishedFrame& frame);
  void failed(const std::string& name, const std::string& why);

  // Writes pending lines. Throws Error(Usage) if they cannot be written.
  void end();

  uint64_t frames() const;                               // number of finished frames
  std::map<std::string, std::string> whyFailed() const;  // reasons by name of the frame or scene

 private:
  void add(const std::string& line);
  int append();  // returns 0 or an errno; requires that mutex_ is locked

  std::filesystem::path path_;
  mutable std::mutex mutex_;
  std::set<uint64_t> frames_;
  std::map<std::string, std::string> failed_;
  std::string waiting_;
  int fd_ = -1;
  int64_t size_ = 0;  // size of all complete lines in the file, in bytes
};

}  // namespace latelight::data
