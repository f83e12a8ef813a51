// Flow control for a page: how many messages are in flight, and the JPEG quality of pictures. Both follow the measured
// rate and latency of the network and the page.
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

  // A message is in flight until it has been written and the page has reported that it was shown; the report is not
  // sufficient by itself. A second one may follow meanwhile unless they are large, so that a slow network receives
  // fewer pictures but no late ones.
  bool maySend() const { return inFlight_.size() < kMaxInFlight && bytes_ <= kMaxBytesInFlight; }
  void sent(uint64_t number, size_t bytes, Time now);
  void written(Time now);                 // the oldest unwritten message has been written
  void shown(uint64_t number, Time now);  // the page has shown this message and all before it

  // JPEG quality, 1 to 100. quality() is for the next picture. coarser() returns the next lower quality for an encoded
  // final picture that would not arrive in time.
  int quality(bool final) const { return final ? kFinest : quality_; }
  void made(size_t bytes);                       // reports the size of an encoded picture while something moves
  int coarser(int quality, size_t bytes) const;  // for a final picture of this size; the same value: it is good

 private:
  static constexpr int kFinest = 92, kFine = 85, kCoarse = 30;
  static constexpr size_t kMaxInFlight = 2, kMaxBytesInFlight = 32 << 20;

  void updateAcknowledged(Time now);

  struct Message {
    uint64_t number;
    size_t bytes;
    Time at;
  };
  std::deque<Message> inFlight_;
  size_t bytes_ = 0;                         // total bytes of inFlight_
  uint64_t written_ = 0, acknowledged_ = 0;  // numbers of messages: written, and no longer in flight
  uint64_t shown_ = 0;                       // highest message number that the page reported
  Time lastShown_{};
  static constexpr double kUnknown = 1e12;
  double rate_ = kUnknown;         // bytes per second
  std::optional<double> latency_;  // round trip, in seconds
  int quality_ = 75;
};

}  // namespace latelight::serve
