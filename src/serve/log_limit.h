// Limits the lines that refused requests add to the log, so that whoever can reach the port cannot fill a disk.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace latelight::serve {

class LogLimit {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr uint32_t kMaxLines = 10;  // per period
  static constexpr std::chrono::seconds kPeriod{10};

  // Returns nothing if a line may not be logged now, else the number of lines that were left out since the last one.
  std::optional<uint64_t> next(Time now) {
    if (!begin_ || now - *begin_ >= kPeriod) begin_ = now, lines_ = 0;
    if (lines_ >= kMaxLines) {
      ++leftOut_;
      return std::nullopt;
    }
    ++lines_;
    const uint64_t before = leftOut_;
    leftOut_ = 0;
    return before;
  }

 private:
  std::optional<Time> begin_;
  uint32_t lines_ = 0;
  uint64_t leftOut_ = 0;
};

}  // namespace latelight::serve
