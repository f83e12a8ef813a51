// The names of all files of a data set, checked before anything is rendered, so that no file replaces another one.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/memory.h"
#include "data/batch/job.h"

namespace latelight::data {

class FileClaims {
 public:
  // `frameName` returns the name of the frame with an index, for messages.
  FileClaims(const Job& job, std::function<std::string(uint64_t)> frameName);

  // Adds the files that the job's formats write for a frame, and for the set to which it belongs. Throws Error(Usage)
  // if one of them is a file of another frame, if another format writes other contents to it, if it is one of the data
  // set's own records, and if a format reads a file of the frame that no format writes.
  void add(const DataFrame& frame);

 private:
  struct Claim {
    size_t format = 0;      // index in the job
    uint64_t contents = 0;  // equal for equal contents
    uint64_t frame = 0;     // index, also of the first frame that contributes to a file of the set
    bool ofSet = false;
  };
  // Looks up parts of names without copies of them.
  struct Hash {
    using is_transparent = void;
    size_t operator()(std::string_view name) const { return std::hash<std::string_view>()(name); }
  };
  using Claims = std::unordered_map<std::string, Claim, Hash, std::equal_to<>>;

  void add(const FormatFile& file, const Claim& claim);
  void insert(Claims& claims, std::string_view name, const Claim& claim);
  void checkIsWritten(const std::string& file, size_t reader) const;
  void compare(std::string_view name, const Claim& claim, const Claims& others, std::string_view other) const;
  uint64_t contentsOf(size_t format, size_t number, const FormatFile& file);
  std::string describe(const Claim& claim) const;

  const Job& job_;
  std::function<std::string(uint64_t)> frameName_;
  Claims files_;
  Claims folders_;                  // any files in these folders, whose names end in a slash
  Claims parents_;                  // a file in each folder that has any
  std::vector<size_t> sameFormat_;  // by format: the index of the first one with the same name and options
  std::unordered_map<std::string, uint64_t> contents_;  // by FormatFile::contents
  uint64_t bytes_ = 0;                                  // not claimed yet
  MemoryClaim memory_;
};

}  // namespace latelight::data
