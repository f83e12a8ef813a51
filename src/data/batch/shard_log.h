// The frames that a shard has made, a line as each is finished: a process that is killed loses none of them, and none
// costs more the more there are.
//
//   {"plan": "0123456789abcdef"}
//   {"stale": ["FILE", ...]}
//   {"frame": {...}}                           as in the manifest
//   {"failed": {"name": ..., "reason": ...}}   until a later line has it as a frame
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <string>

#include "data/batch/manifest.h"

namespace latelight::data {

// What the lines come to. A last one without its end was being written as its process was killed, and does not count.
// Throws Error(BadInput) that names the file where it is no such log.
Manifest readShardLog(const std::filesystem::path& path);

class ShardLog {
 public:
  // Begins it anew with what is there already. Throws Error(Usage) where it can't be written.
  ShardLog(const std::filesystem::path& path, const Manifest& found);
  ~ShardLog();
  ShardLog(const ShardLog&) = delete;
  ShardLog& operator=(const ShardLog&) = delete;

  // From any thread. What can't be written, as on a full disk, waits for the next line, or for the end.
  void finished(const FinishedFrame& frame);
  void failed(const std::string& name, const std::string& why);

  // Throws Error(Usage) where lines still wait, and can't be written.
  void end();

  uint64_t frames() const;                               // that are finished
  std::map<std::string, std::string> whyFailed() const;  // by name

 private:
  void add(const std::string& line);
  int append();  // 0 or an errno; with the mutex taken

  std::filesystem::path path_;
  mutable std::mutex mutex_;
  std::set<uint64_t> frames_;
  std::map<std::string, std::string> failed_;
  std::string waiting_;
  int fd_ = -1;
  int64_t size_ = 0;  // of whole lines
};

}  // namespace latelight::data
