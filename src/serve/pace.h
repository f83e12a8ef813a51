// How much is sent to a page, and how fine: what its network and itself keep up with, by measurement.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace latelight::serve {

class Pace {
 public:
  using Time = std::chrono::steady_clock::time_point;

  // A message is on its way until it has been written and the page says that it was shown; the page's word alone is
  // not enough. One more may follow meanwhile, unless they are large: a slow network gets fewer pictures, and none that
  // is late.
  bool maySend() const { return underway_.size() < kMaxUnderway && bytes_ <= kMaxBytesUnderway; }
  void sent(uint64_t number, size_t bytes, Time now);
  void written(Time now);                 // the oldest message that was not
  void shown(uint64_t number, Time now);  // this message and all before it

  // JPEG's, of the next picture; of one that was made, what it would take to arrive soon.
  int quality(bool final) const { return final ? kFinest : quality_; }
  void made(size_t bytes);                       // a picture while something moves
  int coarser(int quality, size_t bytes) const;  // of a final picture of these bytes; the same: it is good

 private:
  static constexpr int kFinest = 92, kFine = 85, kCoarse = 30;
  static constexpr size_t kMaxUnderway = 2, kMaxBytesUnderway = 32 << 20;

  void settle(Time now);

  struct Message {
    uint64_t number;
    size_t bytes;
    Time at;
  };
  std::deque<Message> underway_;
  size_t bytes_ = 0;                    // of these
  uint64_t written_ = 0, settled_ = 0;  // messages: written, and no longer underway
  uint64_t shown_ = 0;                  // the highest number that the page named
  Time lastShown_{};
  static constexpr double kUnknown = 1e12;
  double rate_ = kUnknown;         // bytes a second
  std::optional<double> latency_;  // seconds, there and back
  int quality_ = 75;
};

}  // namespace latelight::serve
