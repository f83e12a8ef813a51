// The files that the shard logs of a set list. A run that was interrupted before its merge may have replaced files of
// the manifest or of another log, whose records are then outdated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "data/batch/manifest.h"

namespace latelight::data {

class ShardFiles {
 public:
  explicit ShardFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  // Adds the files of a shard log: those of its frames, and the stale ones, which its run may have replaced before it
  // was killed and could record that.
  void add(const Manifest& log);

  // Removes and returns the frames with a file that the logs dispute and that does not have the recorded contents.
  std::vector<FinishedFrame> takeReplaced(std::map<uint64_t, FinishedFrame>& frames) const;

 private:
  struct Contents {
    uint64_t hash = 0;
    bool isDisputed = false;  // the logs do not agree on the hash
  };
  bool dispute(const FileRecord& file) const;
  bool isReplaced(const FinishedFrame& frame) const;

  std::filesystem::path folder_;
  std::unordered_map<std::string, Contents> files_;
};

}  // namespace latelight::data
