// Flow control for pictures: measures latency from small messages and the data rate from large ones, and adapts the
// JPEG quality so that pictures arrive in time.
#include "serve/pace.h"

#include <algorithm>

namespace latelight::serve {

namespace {

constexpr double kMaxMovingSeconds = 0.05,
                 kMaxFinalSeconds = 1;  // maximum transfer times, in seconds: of moving and of final pictures
constexpr size_t kTelling = 4096;       // in bytes; the times of smaller messages do not measure the rate

}  // namespace

void Pace::sent(uint64_t number, size_t bytes, Time now) {
  inFlight_.push_back({number, bytes, now});
  bytes_ += bytes;
}

void Pace::written(Time now) {
  ++written_;
  updateAcknowledged(now);
}

void Pace::shown(uint64_t number, Time now) {
  if (!inFlight_.empty()) shown_ = std::max(shown_, std::min(number, inFlight_.back().number));
  updateAcknowledged(now);
}

// A message waits for the one before it. Its transfer time starts when that one has arrived, or after the latency of an
// empty message, whichever is later.
void Pace::updateAcknowledged(Time now) {
  using Seconds = std::chrono::duration<double>;
  while (!inFlight_.empty() && inFlight_.front().number <= shown_ && acknowledged_ < written_) {
    const Message& message = inFlight_.front();
    const double since = Seconds(now - message.at).count(), sinceLast = Seconds(now - lastShown_).count();
    if (message.bytes < kTelling) {
      if (since < sinceLast) latency_ = latency_ ? std::min(*latency_, since) : since;
    } else {
      const double seconds = std::max(std::min(since - latency_.value_or(0), sinceLast), 1e-3);
      const double measured = static_cast<double>(message.bytes) / seconds;
      rate_ = rate_ >= kUnknown ? measured : 0.7 * rate_ + 0.3 * measured;
    }
    lastShown_ = now;
    bytes_ -= message.bytes;
    ++acknowledged_;
    inFlight_.pop_front();
  }
}

void Pace::made(size_t bytes) {
  const double seconds = static_cast<double>(bytes) / rate_;
  if (seconds > kMaxMovingSeconds) quality_ = std::max(quality_ - 10, kCoarse);
  if (seconds < kMaxMovingSeconds / 2) quality_ = std::min(quality_ + 5, kFine);
}

int Pace::coarser(int quality, size_t bytes) const {
  if (static_cast<double>(bytes) / rate_ <= kMaxFinalSeconds) return quality;
  return std::max(quality - 25, kCoarse);
}

}  // namespace latelight::serve
