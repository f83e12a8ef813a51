#include "serve/pace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace latelight::serve {
namespace {

using Time = Pace::Time;

// A network with this rate and latency, and a page that shows pictures at once.
struct Network {
  double rate, delay;
  double free = 0;  // time at which all messages so far have been sent
};

struct Outcome {
  std::vector<double> late;  // seconds between the creation of a picture and its arrival
  int quality = 0, finalQuality = 0;
};

// Pictures are created whenever they may be sent. `bytes` is the size at quality 85; at other qualities it is
// proportional.
Outcome simulate(Network network, double bytes, double seconds) {
  Pace pace;
  Outcome run;
  struct Underway {
    uint64_t number;
    double shown;
  };
  std::vector<Underway> underway;
  const auto at = [](double t) { return Time{} + std::chrono::nanoseconds(static_cast<int64_t>((1000 + t) * 1e9)); };
  uint64_t number = 0;
  const auto sized = [&](int quality) { return static_cast<size_t>(bytes * quality / 85); };
  for (double t = 0; t < seconds; t += 0.001) {
    while (!underway.empty() && underway.front().shown <= t) {
      pace.shown(underway.front().number, at(underway.front().shown));
      underway.erase(underway.begin());
    }
    if (!pace.maySend()) continue;
    const bool empty = number == 0;  // like the first messages, which reveal the latency
    const size_t size = empty ? 200 : sized(pace.quality(false));
    if (!empty) pace.made(size);
    pace.sent(++number, size, at(t));
    pace.written(at(t));
    network.free = std::max(network.free, t) + static_cast<double>(size) / network.rate;
    underway.push_back({number, network.free + 2 * network.delay});
    run.late.push_back(underway.back().shown - t);
  }
  run.quality = pace.quality(false);
  run.finalQuality = pace.quality(true);
  for (;;) {
    const int coarser = pace.coarser(run.finalQuality, sized(run.finalQuality) * 10);
    if (coarser == run.finalQuality) break;
    run.finalQuality = coarser;
  }
  return run;
}

TEST(PaceTest, AtMostTwoMessagesAreUnderway) {
  Pace pace;
  pace.sent(1, 10, Time{});
  EXPECT_TRUE(pace.maySend());
  pace.sent(2, 10, Time{});
  EXPECT_FALSE(pace.maySend());
  pace.written(Time{});
  pace.written(Time{});
  pace.shown(7, Time{});  // a number that was never sent must not stop the sender
  EXPECT_TRUE(pace.maySend());
}

// Otherwise the server would create any number of messages for a page that reads nothing.
TEST(PaceTest, WhatWasNotWrittenWasNotShown) {
  Pace pace;
  pace.sent(1, 10, Time{});
  pace.sent(2, 10, Time{});
  pace.shown(2, Time{});
  EXPECT_FALSE(pace.maySend());
  pace.written(Time{});
  EXPECT_TRUE(pace.maySend());
  pace.sent(3, 10, Time{});
  EXPECT_FALSE(pace.maySend());
  pace.shown(3, Time{});
  EXPECT_FALSE(pace.maySend());
  pace.written(Time{});
  pace.written(Time{});
  EXPECT_TRUE(pace.maySend());
}

TEST(PaceTest, NoMessageFollowsALargeOne) {
  Pace pace;
  pace.sent(1, 33 << 20, Time{});
  EXPECT_FALSE(pace.maySend());
  pace.written(Time{});
  pace.shown(1, Time{});
  EXPECT_TRUE(pace.maySend());
}

TEST(PaceTest, AFastNetworkGetsFinePictures) {
  for (const double delay : {0.0002, 0.05, 0.2}) {
    const Outcome run = simulate({.rate = 100e6, .delay = delay}, 100e3, 20);
    EXPECT_GE(run.quality, 80) << delay;
    EXPECT_EQ(run.finalQuality, 92) << delay;
    EXPECT_LE(run.late.back(), 2 * delay + 0.01);
  }
}

TEST(PaceTest, ASlowNetworkGetsCoarserOnesWithoutAQueue) {
  const Outcome run = simulate({.rate = 200e3, .delay = 0.02}, 100e3, 20);
  EXPECT_LE(run.quality, 40);
  EXPECT_LT(run.finalQuality, 92);
  // Two pictures of quality 30 take 0.35 s on that network.
  EXPECT_LT(*std::max_element(run.late.end() - 10, run.late.end()), 0.6);
}

}  // namespace
}  // namespace latelight::serve
