#include "output/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.h"
#include "output/srgb.h"

namespace latelight::output {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

double defaultTolerance(ChannelType type) {
  switch (type) {
    case ChannelType::Unorm8:
      return 1 / 255.0;
    case ChannelType::Unorm16:
      return 1 / 65535.0;
    case ChannelType::Integer:
      return 0;
    default:
      return 1e-4;
  }
}

// The same channel of both images.
struct Pair {
  const Channel* a;
  const Channel* b;
  double tolerance;

  // |a - b|. Equal infinities and two NaNs count as no difference; any other pair with a non-finite value is infinite.
  double difference(size_t i) const {
    const double x = a->values[i], y = b->values[i];
    if (x == y || (std::isnan(x) && std::isnan(y))) return 0;
    if (!std::isfinite(x) || !std::isfinite(y)) return kInf;
    return std::abs(x - y);
  }

  // The difference in units of the tolerance. Values above 1 are beyond tolerance.
  double excess(size_t i) const {
    const double d = difference(i);
    if (d == 0 || d == kInf) return d;
    const double scale = std::max({1.0, std::abs(a->values[i]), std::abs(b->values[i])});
    // An 8-bit level is 1/255 only up to rounding: x/255 - (x-1)/255 may be slightly larger.
    const double allowed = tolerance * scale * (1 + 1e-9);
    return allowed > 0 ? d / allowed : kInf;
  }
};

std::string namesOf(const ReadImage& image) {
  std::string names;
  for (const Channel& channel : image.channels) names += (names.empty() ? "" : " ") + channel.name;
  return names;
}

Pair makePair(const Channel& a, const Channel& b, const CompareOptions& options) {
  const double tolerance = std::max(defaultTolerance(a.type), defaultTolerance(b.type));
  return {&a, &b, options.tolerance.value_or(tolerance)};
}

std::vector<Pair> chosenPairs(const ReadImage& a, const ReadImage& b, const CompareOptions& options) {
  std::vector<Pair> pairs;
  for (const std::string& name : options.channels) {
    const Channel* inA = a.find(name);
    const Channel* inB = b.find(name);
    if (!inA && !inB) {
      badUsage("neither image has a channel \"{}\"; the first has {}, the second {}", name, namesOf(a), namesOf(b));
    }
    if (!inA || !inB) badInput("only the {} image has a channel \"{}\"", inA ? "first" : "second", name);
    pairs.push_back(makePair(*inA, *inB, options));
  }
  return pairs;
}

std::vector<Pair> pairsOf(const ReadImage& a, const ReadImage& b, const CompareOptions& options) {
  if (a.width != b.width || a.height != b.height) {
    badInput("the images have different sizes, {}x{} and {}x{}; compare images of the same size", a.width, a.height,
             b.width, b.height);
  }
  if (!options.channels.empty()) return chosenPairs(a, b, options);
  // The name of a single channel depends on the file format, so names are not compared.
  if (a.channels.size() == 1 && b.channels.size() == 1) return {makePair(a.channels[0], b.channels[0], options)};
  std::vector<Pair> pairs;
  for (const Channel& channel : a.channels) {
    if (const Channel* other = b.find(channel.name)) pairs.push_back(makePair(channel, *other, options));
  }
  if (pairs.size() != a.channels.size() || pairs.size() != b.channels.size()) {
    badInput("the images have different channels, {} and {}; select channels with --channel", namesOf(a), namesOf(b));
  }
  return pairs;
}

void findWorst(const std::vector<Pair>& pairs, uint32_t width, Comparison& result) {
  for (const Pair& pair : pairs) {
    for (size_t i = 0; i < pair.a->values.size(); ++i) {
      const double d = pair.difference(i);
      if (!(d > result.maximum)) continue;
      result.maximum = d;
      result.worstX = static_cast<uint32_t>(i % width);
      result.worstY = static_cast<uint32_t>(i / width);
      result.worstChannel = pair.a->name;
    }
  }
}

// Returns the largest excess among a pixel's channels.
double worstExcess(const std::vector<Pair>& pairs, size_t pixel) {
  double worst = 0;
  for (const Pair& pair : pairs) worst = std::max(worst, pair.excess(pixel));
  return worst;
}

}  // namespace

void checkComparable(const ReadImage& a, const ReadImage& b, const CompareOptions& options) {
  pairsOf(a, b, options);
}

Comparison compare(const ReadImage& a, const ReadImage& b, const CompareOptions& options) {
  const std::vector<Pair> pairs = pairsOf(a, b, options);
  Comparison result;
  result.pixels = uint64_t{a.width} * a.height;
  findWorst(pairs, a.width, result);
  double sum = 0, squares = 0;
  uint64_t count = 0;
  for (const Pair& pair : pairs) {
    for (size_t i = 0; i < pair.a->values.size(); ++i) {
      const double d = pair.difference(i);
      if (d == kInf) {
        ++result.unlike;
        continue;
      }
      sum += d;
      squares += d * d;
      ++count;
    }
  }
  for (size_t i = 0; i < result.pixels; ++i) result.beyond += worstExcess(pairs, i) > 1 ? 1 : 0;
  result.mean = count ? sum / static_cast<double>(count) : 0;
  result.psnr = squares > 0 ? 10 * std::log10(static_cast<double>(count) / squares) : kInf;
  if (result.unlike > 0) result.psnr = std::numeric_limits<double>::quiet_NaN();
  return result;
}

std::vector<double> excesses(const ReadImage& a, const ReadImage& b, const CompareOptions& options) {
  const std::vector<Pair> pairs = pairsOf(a, b, options);
  std::vector<double> worst(size_t{a.width} * a.height);
  for (size_t i = 0; i < worst.size(); ++i) worst[i] = worstExcess(pairs, i);
  return worst;
}

Picture differencePicture(uint32_t width, uint32_t height, std::span<const double> excesses) {
  Picture picture{width, height, std::vector<uint8_t>(excesses.size() * 4)};
  for (size_t i = 0; i < excesses.size(); ++i) {
    uint8_t* out = &picture.rgba[4 * i];
    out[3] = 255;
    if (excesses[i] > 1) {
      const double red = std::min(1.0, std::log10(excesses[i]) / 2);  // 0 at the tolerance, 1 at 100 times
      out[0] = 255;
      out[1] = unorm8(static_cast<float>(0.9 * (1 - red)));
      out[2] = 0;
    } else {
      out[0] = out[1] = out[2] = unorm8(static_cast<float>(excesses[i] * 0.5));
    }
  }
  return picture;
}

}  // namespace latelight::output
