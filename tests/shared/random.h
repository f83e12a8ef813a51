// Pseudorandom numbers that are the same on every machine.
#pragma once

#include <cmath>
#include <cstdint>

#include "shared/lang.h"

namespace latelight::shared {

class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  // splitmix64 (Steele et al. 2014).
  uint64_t bits() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  float uniform() { return static_cast<float>(bits() >> 40) * 0x1p-24f; }  // [0, 1)
  float uniform(float low, float high) { return low + (high - low) * uniform(); }
  float logUniform(float low, float high) { return low * std::pow(high / low, uniform()); }
  vec3 color() { return vec3(uniform(), uniform(), uniform()); }
  vec3 direction() {  // uniform over the sphere
    const double z = 2.0 * uniform() - 1.0;
    const double angle = 2.0 * M_PI * uniform();
    const double r = std::sqrt(1.0 - z * z);
    return vec3(static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle)),
                static_cast<float>(z));
  }
  vec3 directionAbout(vec3 axis) {  // uniform over the hemisphere
    const vec3 d = direction();
    return dot(d, axis) < 0.0f ? d * -1.0f : d;
  }

 private:
  uint64_t state_;
};

}  // namespace latelight::shared
