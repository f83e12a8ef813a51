#include "output/compare_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>
#include <set>

#include "base/error.h"
#include "base/lowercase.h"
#include "output/srgb.h"

namespace latelight::output {

namespace {

constexpr double kOneFileOnly = std::numeric_limits<double>::infinity();

// Default tolerances. For colors and other differences the tolerance follows from the channels' types (compare.h).
double defaultTolerance(Measure measure) {
  switch (measure) {
    case Measure::Relative:
      return 1e-4;
    case Measure::Angle:
    case Measure::Pixels:
      return 0.01;
    default:
      return 0;
  }
}

// --- assignment of channels to outputs -------------------------------------------------------------------------------

struct Group {
  std::string name;
  Measure measure = Measure::Difference;
  std::vector<std::string> channels;
};

bool hasAll(const std::set<std::string>& channels, std::span<const std::string_view> wanted) {
  return std::ranges::all_of(wanted, [&](std::string_view name) { return channels.contains(std::string(name)); });
}

// Removes the channels of an output from `left` and returns them as a group. Returns nothing if one is missing.
std::optional<Group> takeOutput(const AovInfo& aov, std::set<std::string>& left) {
  std::span<const std::string_view> wanted = std::span(aov.exrChannels).first(aov.channels);
  // Color may lack the alpha channel (coverage), and motion the one to the next frame.
  if (aov.aov == Aov::Color && !hasAll(left, wanted)) wanted = wanted.first(3);
  if (aov.aov == Aov::Motion && !hasAll(left, wanted)) wanted = wanted.first(2);
  if (!hasAll(left, wanted)) return std::nullopt;
  Group group{std::string(aov.name), measureOf(aov), {}};
  for (const std::string_view name : wanted) {
    group.channels.emplace_back(name);
    left.erase(std::string(name));
  }
  return group;
}

// Returns the prefix that groups channels: "cluster" for "cluster.instance".
std::string prefixOf(const std::string& channel) {
  return channel.substr(0, channel.rfind('.'));
}

bool isPng(const ReadImage& image) {
  return std::ranges::all_of(image.channels, [](const Channel& channel) {
    return channel.type == ChannelType::Unorm8 || channel.type == ChannelType::Unorm16;
  });
}

// Returns true for a PNG file of colors or grays. Files that asOutput() decoded have other channels.
bool isColorPng(const ReadImage& image) {
  return isPng(image) && (image.find("R") || image.find("Y"));
}

std::vector<Group> groupsOf(const ReadImage& image, const std::vector<std::string>& chosen, bool grayIsColor) {
  std::set<std::string> left;
  for (const Channel& channel : image.channels)
    if (chosen.empty() || std::ranges::find(chosen, channel.name) != chosen.end()) left.insert(channel.name);
  std::vector<Group> groups;
  for (const AovInfo& aov : aovs())
    if (auto group = takeOutput(aov, left)) groups.push_back(*std::move(group));
  if (grayIsColor && left.contains("Y")) {
    groups.push_back({"color", Measure::Color, {"Y"}});
    left.erase("Y");
    if (left.erase("A")) groups.back().channels.emplace_back("A");
  }
  std::map<std::string, Group> others;
  for (const std::string& channel : left) {
    Group& group = others[prefixOf(channel)];
    group.name = prefixOf(channel);
    group.channels.push_back(channel);
  }
  for (auto& [name, group] : others) groups.push_back(std::move(group));
  return groups;
}

// --- measures -------------------------------------------------------------------------------------------------------

using Vector = glm::dvec3;

// Returns a pixel of up to three channels.
Vector vectorAt(std::span<const Channel* const> channels, size_t pixel) {
  Vector v(0);
  for (size_t c = 0; c < std::min<size_t>(channels.size(), 3); ++c) v[static_cast<int>(c)] = channels[c]->values[pixel];
  return v;
}

bool isFinite(Vector v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// A difference of at most `step`, the file's rounding step, counts as none.
double relativeError(Vector a, Vector b, double step) {
  const double difference = glm::length(a - b);
  return difference > step * (1 + 1e-6) ? (difference - step) / std::max(glm::length(a), glm::length(b)) : 0;
}

// The angle in degrees. Background has no direction: only two background pixels are equal.
double angle(Vector a, Vector b) {
  const bool isA = glm::length(a) > 0, isB = glm::length(b) > 0;
  if (!isA || !isB) return isA == isB ? 0 : kOneFileOnly;
  // The arc tangent is accurate for small angles, unlike an arc cosine.
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / std::numbers::pi;
}

struct Pixels {
  std::vector<const Channel*> a, b;

  double error(Measure measure, size_t pixel) const {
    if (measure == Measure::Identity) return a[0]->values[pixel] == b[0]->values[pixel] ? 0 : 1;
    if (measure == Measure::Pixels) {
      double worst = 0;
      for (size_t c = 0; c + 1 < a.size(); c += 2)
        worst = std::max(worst, error(measure, pixel, std::span(a).subspan(c, 2), std::span(b).subspan(c, 2)));
      return worst;
    }
    return error(measure, pixel, a, b);
  }

 private:
  static double error(Measure measure, size_t pixel, std::span<const Channel* const> a,
                      std::span<const Channel* const> b) {
    const Vector x = vectorAt(a, pixel), y = vectorAt(b, pixel);
    if (!isFinite(x) || !isFinite(y)) {
      const auto same = [](double one, double other) { return one == other || (std::isnan(one) && std::isnan(other)); };
      return same(x.x, y.x) && same(x.y, y.y) && same(x.z, y.z) ? 0 : kOneFileOnly;
    }
    if (measure == Measure::Angle) return angle(x, y);
    constexpr double kMillimeter = 1e-3;
    const bool isRounded = a[0]->type == ChannelType::Unorm16 || b[0]->type == ChannelType::Unorm16;
    return measure == Measure::Relative ? relativeError(x, y, isRounded ? kMillimeter : 0) : glm::length(x - y);
  }
};

void setWorst(size_t pixel, uint32_t width, OutputDifference& result) {
  result.worstX = static_cast<uint32_t>(pixel % width);
  result.worstY = static_cast<uint32_t>(pixel / width);
}

// The worst pixel is that of the maximum, or, if no pixel has an error that can be measured, the first unlike one.
void measurePixels(const Pixels& channels, uint32_t width, OutputDifference& result) {
  double sum = 0;
  uint64_t count = 0;
  result.excesses.resize(result.pixels);
  for (size_t i = 0; i < result.pixels; ++i) {
    const double error = channels.error(result.measure, i);
    result.excesses[i] = error == 0 ? 0 : result.tolerance > 0 ? error / result.tolerance : kOneFileOnly;
    result.beyond += error > result.tolerance;
    if (error == kOneFileOnly) {
      if (result.unlike++ == 0 && result.maximum == 0) setWorst(i, width, result);
      continue;
    }
    sum += error;
    ++count;
    if (error <= result.maximum) continue;
    result.maximum = error;
    setWorst(i, width, result);
  }
  result.mean = count ? sum / static_cast<double>(count) : 0;
}

// --- colors ----------------------------------------------------------------------------------------------------------

bool isCoverage(const std::string& channel) {
  return channel == "A";
}

// Returns the colors of a PNG file as float files store them: linear and premultiplied with alpha.
ReadImage linearOf(const ReadImage& image) {
  ReadImage result = image;
  const Channel* coverage = image.find("A");
  for (Channel& channel : result.channels) {
    channel.type = ChannelType::Float;
    if (isCoverage(channel.name)) continue;
    for (size_t i = 0; i < channel.values.size(); ++i)
      channel.values[i] =
          linearFromSrgb(static_cast<float>(channel.values[i])) * (coverage ? coverage->values[i] : 1.0);
  }
  return result;
}

// Returns the largest step between two levels of a PNG file in linear colors, or the tolerance of floats if that is
// larger.
double linearTolerance(const ReadImage& png) {
  constexpr double kFloatTolerance = 1e-4;
  const float levels = png.channels.front().type == ChannelType::Unorm16 ? 65535.0f : 255.0f;
  return std::max(1.0 - linearFromSrgb((levels - 1) / levels), kFloatTolerance);
}

// Returns what a screen shows of the colors, over black: FLIP compares linear values in [0, 1].
LinearPicture shownOnScreen(const ReadImage& image, const std::vector<std::string>& channels) {
  const ReadImage linear = isColorPng(image) ? linearOf(image) : image;
  std::vector<const Channel*> colors;
  for (const std::string& name : channels)
    if (!isCoverage(name)) colors.push_back(linear.find(name));
  LinearPicture picture{image.width, image.height, std::vector<glm::dvec3>(size_t{image.width} * image.height)};
  for (size_t i = 0; i < picture.rgb.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double value = colors[std::min<size_t>(static_cast<size_t>(c), colors.size() - 1)]->values[i];
      picture.rgb[i][c] = value > 0 ? std::min(value, 1.0) : 0;  // NaN becomes 0
    }
  return picture;
}

void measureChannels(const ReadImage& a, const ReadImage& b, std::optional<double> tolerance,
                     OutputDifference& result) {
  const CompareOptions options{tolerance, result.channels};
  const Comparison c = compare(a, b, options);
  result.excesses = excesses(a, b, options);
  result.maximum = c.maximum;
  result.mean = c.mean;
  result.worstX = c.worstX;
  result.worstY = c.worstY;
  result.worstChannel = c.worstChannel;
  result.beyond = c.beyond;
  result.unlike = c.unlike;
  result.psnr = c.psnr;
}

double meanFlip(const ReadImage& a, const ReadImage& b, const OutputDifference& result, double pixelsPerDegree) {
  const std::vector<double> errors =
      flip(shownOnScreen(a, result.channels), shownOnScreen(b, result.channels), pixelsPerDegree);
  double sum = 0;
  for (const double error : errors) sum += error;
  return errors.empty() ? 0 : sum / static_cast<double>(errors.size());
}

struct MeasureOptions : OutputOptions {
  std::optional<double> defaultTolerance;  // of colors and differences, if it does not follow from the channels' types
};

OutputDifference measure(const ReadImage& a, const ReadImage& b, const Group& group, const MeasureOptions& options) {
  OutputDifference result{.output = group.name, .channels = group.channels, .measure = group.measure};
  result.pixels = uint64_t{a.width} * a.height;
  std::optional<double> tolerance = group.measure == Measure::Identity ? std::nullopt : options.tolerance;
  if (const auto own = options.tolerances.find(group.name); own != options.tolerances.end()) tolerance = own->second;
  if (group.measure == Measure::Identity && tolerance.value_or(0) > 0)
    badUsage("--tolerance does not apply to \"{0}\", whose values are equal or not: omit {0}={1}", group.name,
             *tolerance);
  result.tolerance = tolerance.value_or(defaultTolerance(group.measure));
  if (group.measure == Measure::Color || group.measure == Measure::Difference) {
    measureChannels(a, b, tolerance ? tolerance : options.defaultTolerance, result);
    if (group.measure == Measure::Color) result.flip = meanFlip(a, b, result, options.pixelsPerDegree);
    return result;
  }
  Pixels channels;
  for (const std::string& name : group.channels) {
    channels.a.push_back(a.find(name));
    channels.b.push_back(b.find(name));
  }
  measurePixels(channels, a.width, result);
  return result;
}

// --- files named after an output -------------------------------------------------------------------------------------

// Decodes a PNG code to the number that it stands for (PngCoding).
double decoded(PngCoding coding, double code) {
  constexpr double kLevels = 65535;
  switch (coding) {
    case PngCoding::Signed:
      return code * 2 - 1;
    case PngCoding::Millimetre:
      return code > 0 ? code * kLevels / 1000 : std::numeric_limits<double>::infinity();
    case PngCoding::Count:
      return code * kLevels;
    default:
      return code;
  }
}

ReadImage decodedPng(const ReadImage& image, const AovInfo& aov) {
  ReadImage result{image.width, image.height, {}};
  const size_t pixels = size_t{image.width} * image.height;
  if (aov.png == PngCoding::IdBytes) {
    Channel ids{std::string(aov.exrChannels[0]), ChannelType::Integer, std::vector<double>(pixels)};
    for (size_t c = 0; c < image.channels.size(); ++c)
      for (size_t i = 0; i < pixels; ++i)
        ids.values[i] += std::round(image.channels[c].values[i] * 255) * std::exp2(8.0 * double(c));
    result.channels.push_back(std::move(ids));
    return result;
  }
  for (uint32_t c = 0; c < aov.channels; ++c) {
    const ChannelType type = aov.png == PngCoding::Millimetre ? ChannelType::Unorm16 : ChannelType::Float;
    Channel channel{std::string(aov.exrChannels[c]), type, image.channels[c].values};
    for (double& value : channel.values) value = decoded(aov.png, value);
    result.channels.push_back(std::move(channel));
  }
  if (aov.png == PngCoding::Signed)  // 0 0 0 is background
    for (size_t i = 0; i < pixels; ++i)
      if (std::ranges::all_of(image.channels, [&](const Channel& channel) { return channel.values[i] == 0; }))
        for (Channel& channel : result.channels) channel.values[i] = 0;
  return result;
}

// Returns the output in a file name: depth for "out.depth" and "depth".
const AovInfo* outputNamed(const std::filesystem::path& path) {
  const std::string stem = path.stem().string();
  return findAov(stem.substr(stem.rfind('.') + 1));
}

}  // namespace

Measure measureOf(const AovInfo& aov) {
  if (holdsIntegers(aov.aov)) return Measure::Identity;
  if (aov.png == PngCoding::Signed) return Measure::Angle;
  if (aov.png == PngCoding::Display || aov.png == PngCoding::Srgb) return Measure::Color;
  // Scene flow is a difference of positions: of surfaces that hardly move, only rounding is left, which has no relation
  // to the length of the flow.
  if (aov.aov == Aov::SceneFlow) return Measure::Difference;
  if (aov.unit == "m") return Measure::Relative;
  return aov.unit == "px" ? Measure::Pixels : Measure::Difference;
}

std::string_view unitOf(Measure measure) {
  if (measure == Measure::Angle) return "degrees";
  return measure == Measure::Pixels ? "pixels" : "";
}

ReadImage asOutput(const ReadImage& image, const std::filesystem::path& path) {
  const AovInfo* aov = outputNamed(path);
  const bool known = aov && aov->png != PngCoding::Display && !image.channels.empty();
  if (!known) return image;
  if (isPng(image)) {
    const size_t needed = aov->png == PngCoding::IdBytes ? 4 : aov->png == PngCoding::Fraction ? 3 : aov->channels;
    const bool decodes = aov->png != PngCoding::None && aov->png != PngCoding::Srgb;
    return decodes && image.channels.size() == needed ? decodedPng(image, *aov) : image;
  }
  const size_t count = image.channels.size();
  const bool fits = count == aov->channels || (aov->aov == Aov::Motion && count == 2);  // to the previous frame only
  if (lowercaseExtension(path) != ".npy" || !fits) return image;
  ReadImage renamed = image;
  for (size_t c = 0; c < count; ++c) renamed.channels[c].name = aov->exrChannels[c];
  return renamed;
}

std::vector<OutputDifference> compareOutputs(const ReadImage& a, const ReadImage& b, const OutputOptions& options) {
  checkComparable(a, b, {options.tolerance, options.channels});
  const bool isPngA = isColorPng(a), isPngB = isColorPng(b);
  MeasureOptions measureOptions{options, std::nullopt};
  if (isPngA != isPngB) measureOptions.defaultTolerance = linearTolerance(isPngA ? a : b);
  const ReadImage first = isPngA && !isPngB ? linearOf(a) : a;
  ReadImage second = isPngB && !isPngA ? linearOf(b) : b;
  // The name of a single channel depends on the file format, so it is replaced.
  if (options.channels.empty() && a.channels.size() == 1) second.channels[0].name = a.channels[0].name;
  std::vector<OutputDifference> results;
  for (const Group& group : groupsOf(first, options.channels, isPngA || isPngB))
    results.push_back(measure(first, second, group, measureOptions));
  for (const auto& [name, tolerance] : options.tolerances)
    if (std::ranges::find(results, name, &OutputDifference::output) == results.end())
      badUsage("--tolerance names the output \"{}\", which the files do not have", name);
  return results;
}

}  // namespace latelight::output
