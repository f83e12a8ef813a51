#include "render/sensor/exposure_plane.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "base/parallel.h"
#include "base/philox.h"
#include "render/sensor/mosaic.h"

namespace latelight::render {

namespace {

// The random bits of one pixel, for the distributions of the standard library.
class PixelRandom {
 public:
  using result_type = uint32_t;
  PixelRandom(uint32_t seed, uint64_t frame, uint32_t pixel)
      : key_{seed, kSensor}, counter_{0, pixel, static_cast<uint32_t>(frame), static_cast<uint32_t>(frame >> 32)} {}

  static constexpr uint32_t min() { return 0; }
  static constexpr uint32_t max() { return ~0u; }
  uint32_t operator()() {
    if (left_ == 0) {
      block_ = philox(counter_, key_);
      ++counter_[0];
      left_ = 4;
    }
    return block_[4 - left_--];
  }

 private:
  static constexpr uint32_t kSensor = 0x73656e73;  // separates this stream from others with the same seed
  std::array<uint32_t, 2> key_;
  PhiloxBlock counter_, block_{};
  uint32_t left_ = 0;
};

class Converter {
 public:
  explicit Converter(const Settings& s)
      : fullWell_(s.fullWell),
        gain_(s.gain),
        readNoise_(s.readNoise),
        black_(s.blackLevel),
        range_(static_cast<double>((1u << s.bitDepth) - 1) - s.blackLevel) {}

  // Returns the signal that a pixel reads for radiance `light`, of which 1 is the highest value that it can read.
  double read(double light, PixelRandom& random) const {
    if (fullWell_ == 0) return light;
    const double electrons = std::min(collected(light * fullWell_ / gain_, random), fullWell_) + noise(random);
    const double number = std::round(black_ + electrons * gain_ / fullWell_ * range_);
    return (std::clamp(number, 0.0, black_ + range_) - black_) / range_;
  }

 private:
  // A mean of several times the capacity saturates the pixel, as any higher one does.
  double collected(double mean, PixelRandom& random) const {
    mean = std::min(mean, 4 * fullWell_ + 1000);
    return mean > 0 ? static_cast<double>(std::poisson_distribution<int64_t>(mean)(random)) : 0;
  }
  double noise(PixelRandom& random) const {
    return readNoise_ > 0 ? std::normal_distribution<double>(0, readNoise_)(random) : 0;
  }

  double fullWell_, gain_, readNoise_, black_, range_;
};

}  // namespace

SensorPlane exposeSensor(const std::vector<float>& rgba, const Settings& s, uint64_t seed) {
  SensorPlane plane{s.width, s.height, std::vector<float>(size_t{3} * s.width * s.height)};
  const Converter converter(s);
  parallelFor(s.height, 4, [&](size_t begin, size_t end) {
    for (size_t i = begin * s.width; i < end * s.width; ++i) {
      PixelRandom random(s.noiseSeed, seed, static_cast<uint32_t>(i));
      const auto read = [&](size_t k) {
        plane.rgb[3 * i + k] = static_cast<float>(converter.read(rgba[4 * i + k], random));
      };
      if (s.bayer != Bayer::None) {
        read(filterAt(s.bayer, static_cast<uint32_t>(i % s.width), static_cast<uint32_t>(i / s.width)));
        continue;
      }
      for (size_t k = 0; k < 3; ++k) read(k);
    }
  });
  return plane;
}

}  // namespace latelight::render
