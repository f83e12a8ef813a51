// Counter-based random numbers that are the same on every machine (base/philox.h). A stream depends on `seed`, `number`
// and the name of the quantity that it is drawn for, so an addition to a job does not change its other random values.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "base/philox.h"

namespace latelight::data {

using Block = PhiloxBlock;
using latelight::philox;

// A stream of random numbers. `what` names the quantity.
class Random {
 public:
  Random(uint64_t seed, uint64_t number, std::string_view what)
      : key_{static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32)},
        counter_{0, hash32(what), static_cast<uint32_t>(number), static_cast<uint32_t>(number >> 32)} {}

  uint32_t bits() {
    if (left_ == 0) {
      block_ = philox(counter_, key_);
      ++counter_[0];
      left_ = 4;
    }
    return block_[4 - left_--];
  }
  // Uniform in [0, 1), a multiple of 2^-53.
  double unit() {
    const uint64_t high = bits() >> 5, low = bits() >> 6;
    return static_cast<double>(high << 26 | low) * 0x1p-53;
  }
  double between(double low, double high) { return low + (high - low) * unit(); }
  // Uniform in [0, count), without bias (Lemire 2019, "Fast random integer generation in an interval").
  uint32_t below(uint32_t count) {
    uint64_t product = uint64_t{bits()} * count;
    const uint32_t biased = (0u - count) % count;  // 2^32 mod count: lower products would bias the result
    while (static_cast<uint32_t>(product) < biased) product = uint64_t{bits()} * count;
    return static_cast<uint32_t>(product >> 32);
  }
  // Returns `chosen` different integers of [0, count) in the order they were drawn. `chosen` is at most `count`.
  std::vector<uint32_t> choose(uint32_t chosen, uint32_t count) {
    std::vector<uint32_t> all(count);
    for (uint32_t i = 0; i < count; ++i) all[i] = i;
    for (uint32_t i = 0; i < chosen; ++i) std::swap(all[i], all[i + below(count - i)]);
    all.resize(chosen);
    return all;
  }

 private:
  std::array<uint32_t, 2> key_;
  Block counter_, block_{};
  uint32_t left_ = 0;
};

}  // namespace latelight::data
