// The FLIP metric. The color pipeline filters both images with the observer's contrast sensitivity and maps their HyAB
// distance in L*a*b* to [0, 1]. The feature pipeline compares edges and points of the luminance. flip() combines both
// into `errors`, one value per pixel. Section numbers are those of the paper cited in flip.h.
#include "output/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "base/parallel.h"

namespace latelight::output {

using glm::dmat3, glm::dvec3;

namespace {

constexpr double kPi = std::numbers::pi;

// --- color spaces (section 3 of the paper) ---------------------------------------------------------------------------

// Linear Rec.709 to CIE XYZ, column by column. The white point is the XYZ of (1, 1, 1).
const dmat3 kXyzFromRgb{10135552 / 24577794.0, 2613072 / 12288897.0, 1425312 / 73733382.0,
                        8788810 / 24577794.0,  8788810 / 12288897.0, 8788810 / 73733382.0,
                        4435075 / 24577794.0,  887015 / 12288897.0,  70074185 / 73733382.0};
const dmat3 kRgbFromXyz = glm::inverse(kXyzFromRgb);
const dvec3 kWhite = kXyzFromRgb * dvec3(1);

// The opponent color space for contrast sensitivity: luminance, red-green, blue-yellow.
dvec3 opponentOf(dvec3 rgb) {
  const dvec3 n = kXyzFromRgb * rgb / kWhite;
  return {116 * n.y - 16, 500 * (n.x - n.y), 200 * (n.y - n.z)};
}

dvec3 rgbOf(dvec3 opponent) {
  const double y = (opponent.x + 16) / 116;
  return kRgbFromXyz * (dvec3(opponent.y / 500 + y, y, y - opponent.z / 200) * kWhite);
}

// CIE L*a*b*, with a and b scaled by luminance, because dark colors appear less colorful (Hunt effect).
dvec3 labOf(dvec3 rgb) {
  constexpr double kDelta = 6.0 / 29;
  const auto curve = [](double t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const dvec3 n = kXyzFromRgb * rgb / kWhite;
  const dvec3 f(curve(n.x), curve(n.y), curve(n.z));
  const double lightness = 116 * f.y - 16;
  return {lightness, 0.01 * lightness * 500 * (f.x - f.y), 0.01 * lightness * 200 * (f.y - f.z)};
}

// The HyAB distance, which suits large color differences.
double hyab(dvec3 a, dvec3 b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

// --- filters --------------------------------------------------------------------------------------------------------

using Grid = std::vector<double>;
using Kernel = std::vector<double>;  // odd length, centered at 0

struct Size {
  uint32_t width, height;
};

// Filters along rows or along columns. Edge values are repeated.
Grid filtered(const Grid& in, Size size, const Kernel& kernel, bool alongRows) {
  const auto radius = static_cast<int64_t>(kernel.size() / 2);
  const int64_t last = int64_t{alongRows ? size.width : size.height} - 1;
  const size_t step = alongRows ? 1 : size.width;
  Grid out(in.size());
  parallelFor(size.height, 16, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (size_t x = 0; x < size.width; ++x) {
        const auto at = static_cast<int64_t>(alongRows ? x : y);
        const double* line = &in[alongRows ? y * size.width : x];
        double sum = 0;
        for (int64_t i = -radius; i <= radius; ++i)
          sum += kernel[static_cast<size_t>(i + radius)] *
                 line[static_cast<size_t>(std::clamp(at + i, int64_t{0}, last)) * step];
        out[y * size.width + x] = sum;
      }
  });
  return out;
}

Grid filtered(const Grid& in, Size size, const Kernel& alongRows, const Kernel& alongColumns) {
  return filtered(filtered(in, size, alongRows, true), size, alongColumns, false);
}

template <typename ValueAt>
Kernel kernelOf(int radius, const ValueAt& valueAt) {
  Kernel kernel;
  for (int i = -radius; i <= radius; ++i) kernel.push_back(valueAt(double(i)));
  return kernel;
}

double sumOf(const Kernel& kernel) {
  double sum = 0;
  for (const double weight : kernel) sum += weight;
  return sum;
}

// --- the color pipeline (section 4.1) --------------------------------------------------------------------------------

// The contrast sensitivity function of a channel: a sum of two Gaussians of the distance in degrees.
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr Sensitivity kSensitivities[] = {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};

Grid asSeen(const Grid& channel, Size size, const Sensitivity& s, double pixelsPerDegree) {
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * pixelsPerDegree));
  const auto gaussian = [&](double b) {
    return kernelOf(radius,
                    [&](double i) { return std::exp(-kPi * kPi * (i / pixelsPerDegree) * (i / pixelsPerDegree) / b); });
  };
  const Kernel first = gaussian(s.b1);
  Grid seen = filtered(channel, size, first, first);
  const double weight = s.a1 * std::sqrt(kPi / s.b1);
  double total = weight * sumOf(first) * sumOf(first);
  for (double& value : seen) value *= weight;
  if (s.a2 > 0) {
    const Kernel second = gaussian(s.b2);
    const double other = s.a2 * std::sqrt(kPi / s.b2);
    total += other * sumOf(second) * sumOf(second);
    const Grid wide = filtered(channel, size, second, second);
    for (size_t i = 0; i < seen.size(); ++i) seen[i] += other * wide[i];
  }
  for (double& value : seen) value /= total;
  return seen;
}

using Opponent = std::array<Grid, 3>;

Opponent opponentsOf(const LinearPicture& picture) {
  Opponent planes;
  for (Grid& plane : planes) plane.resize(picture.rgb.size());
  for (size_t i = 0; i < picture.rgb.size(); ++i) {
    const dvec3 opponent = opponentOf(picture.rgb[i]);
    for (size_t c = 0; c < 3; ++c) planes[c][i] = opponent[static_cast<int>(c)];
  }
  return planes;
}

std::vector<dvec3> labsOf(const Opponent& planes, Size size, double pixelsPerDegree) {
  Opponent seen;
  for (size_t c = 0; c < 3; ++c) seen[c] = asSeen(planes[c], size, kSensitivities[c], pixelsPerDegree);
  std::vector<dvec3> labs(planes[0].size());
  for (size_t i = 0; i < labs.size(); ++i)
    labs[i] = labOf(glm::clamp(rgbOf({seen[0][i], seen[1][i], seen[2][i]}), 0.0, 1.0));
  return labs;
}

// Maps a color difference to [0, 1]. Small differences use most of the range.
double redistributed(double difference) {
  constexpr double kExponent = 0.7, kSplit = 0.4, kShare = 0.95;
  static const double largest = std::pow(hyab(labOf({0, 1, 0}), labOf({0, 0, 1})), kExponent);
  const double power = std::pow(difference, kExponent), split = kSplit * largest;
  if (power < split) return kShare / split * power;
  return kShare + (power - split) / (largest - split) * (1 - kShare);
}

// --- the feature pipeline (section 4.2) -----------------------------------------------------------------------------

// Scales the kernel so that its positive weights sum to 1 and its negative weights to -1.
Kernel balanced(Kernel kernel) {
  double positive = 0, negative = 0;
  for (const double weight : kernel) (weight > 0 ? positive : negative) += weight;
  for (double& weight : kernel) weight /= weight > 0 ? positive : -negative;
  return kernel;
}

struct Features {
  Grid edges, points;
};

Features featuresOf(const Grid& luminance, Size size, double pixelsPerDegree) {
  constexpr double kWidth = 0.082;  // degrees
  const double deviation = 0.5 * kWidth * pixelsPerDegree, square = deviation * deviation;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  const auto bell = [&](double i) { return std::exp(-i * i / (2 * square)); };
  Kernel smooth = kernelOf(radius, bell);
  const double total = sumOf(smooth);
  for (double& weight : smooth) weight /= total;
  const Kernel edge = balanced(kernelOf(radius, [&](double i) { return -i * bell(i); }));
  const Kernel point = balanced(kernelOf(radius, [&](double i) { return (i * i / square - 1) * bell(i); }));
  Grid normalized(luminance.size());
  for (size_t i = 0; i < normalized.size(); ++i) normalized[i] = (luminance[i] + 16) / 116;
  const auto magnitude = [&](const Kernel& kernel) {
    Grid across = filtered(normalized, size, kernel, smooth);
    const Grid down = filtered(normalized, size, smooth, kernel);
    for (size_t i = 0; i < across.size(); ++i) across[i] = std::hypot(across[i], down[i]);
    return across;
  };
  return {magnitude(edge), magnitude(point)};
}

}  // namespace

std::vector<double> flip(const LinearPicture& reference, const LinearPicture& test, double pixelsPerDegree) {
  constexpr double kFeatureExponent = 0.5;
  const Size size{reference.width, reference.height};
  const Opponent a = opponentsOf(reference), b = opponentsOf(test);
  const std::vector<dvec3> colorsA = labsOf(a, size, pixelsPerDegree), colorsB = labsOf(b, size, pixelsPerDegree);
  const Features featuresA = featuresOf(a[0], size, pixelsPerDegree),
                 featuresB = featuresOf(b[0], size, pixelsPerDegree);
  std::vector<double> errors(reference.rgb.size());
  for (size_t i = 0; i < errors.size(); ++i) {
    const double color = redistributed(hyab(colorsA[i], colorsB[i]));
    const double feature = std::max(std::abs(featuresA.edges[i] - featuresB.edges[i]),
                                    std::abs(featuresA.points[i] - featuresB.points[i]));
    errors[i] = std::pow(color, 1 - std::pow(feature / std::numbers::sqrt2, kFeatureExponent));
  }
  return errors;
}

}  // namespace latelight::output
