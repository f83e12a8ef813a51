// Approximates the GGX lobe of a rough surface by lookups into an environment's prefiltered maps. The table
// (ggxLobeTable) stores, per n.v and perceptual roughness, the direction's lean towards the normal, the specular level,
// and the fraction of the diffuse map.
//
// A rough lobe is not symmetric about the reflected ray: it leans towards the normal, is stretched away from it at
// grazing views, and has long tails. With a few lookups, shading can use a mixture of a symmetric lobe (two levels of
// the specular maps in one direction) and the cosine lobe about the normal (the diffuse map, which is sampled anyway).
// The table stores the mixture whose mean radiance differs least from the true lobe's on average over many
// environments: least squares over bands of spherical harmonics, weighted by the typical power of environments in each
// band.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/parallel.h"
#include "scene/environment/environment.h"
#include "scene/environment/ggx_samples.h"
#include "scene/environment/table_cache.h"
#include "scene/environment/tree.h"
#include "shared/brdf/ggx.h"

namespace latelight::scene {
namespace {

using glm::vec3;

// Must be incremented whenever the table's values change.
constexpr uint32_t kLobeVersion = 1;

// The sampled bands. Lobes so narrow that only higher bands resolve them match their own levels anyway.
constexpr std::array kBands{1, 2, 3, 4, 5, 6, 8, 10, 13, 17, 23, 32, 48};
using Moments = std::array<double, kBands.size()>;  // means of Legendre polynomials over a lobe about an axis

// Weights of the bands' squared errors. Natural light has approximately the power b^-2 in each of the 2b + 1 harmonics
// of band b; a lamp has equal power in all. The weights are steeper than either, because images show light roughly
// logarithmically. Among the exponents 2, 2.5, 3 and 3.5 the last has the smallest mean error in 8-bit levels over the
// environments of docs/accuracy.md.
Moments bandWeights() {
  Moments weights;
  for (size_t i = 0; i < kBands.size(); ++i) {
    const double low = i > 0 ? (kBands[i - 1] + kBands[i]) * 0.5 : 0.5;
    const double high = i + 1 < kBands.size() ? (kBands[i] + kBands[i + 1]) * 0.5 : kBands[i] * 1.25;
    weights[i] = (2 * kBands[i] + 1) * std::pow(kBands[i], -3.5) * (high - low);
  }
  return weights;
}

// Returns weighted sums of the bands' Legendre polynomials at many cosines. The arithmetic is in floats with the loop
// over samples inside the one over bands, so that it vectorizes.
Moments legendreSums(const std::vector<float>& cosines, const std::vector<float>& weights) {
  Moments sums{};
  std::vector<float> before(cosines.size(), 1.0f), now = cosines;
  size_t next = 0;
  for (int band = 1; next < kBands.size(); ++band) {
    if (band == kBands[next]) {
      for (size_t i = 0; i < now.size(); ++i) sums[next] += double{weights[i]} * now[i];
      ++next;
    }
    const float up = static_cast<float>(2 * band + 1) / static_cast<float>(band + 1);
    const float down = static_cast<float>(band) / static_cast<float>(band + 1);
    for (size_t i = 0; i < now.size(); ++i) {
      const float after = up * cosines[i] * now[i] - down * before[i];
      before[i] = now[i];
      now[i] = after;
    }
  }
  return sums;
}

// Returns the moments of a rotationally symmetric lobe about its axis.
Moments momentsOf(Lobe lobe, float alpha) {
  constexpr int kSteps = 4000;
  std::vector<float> cosines(kSteps), weights(kSteps);
  double whole = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) / kSteps, angle = t * t * t * std::numbers::pi / 2;  // denser near the axis
    cosines[i] = static_cast<float>(std::cos(angle));
    double weight = std::cos(angle);
    toLobeWeight(lobe, alpha, weight);
    weights[i] = static_cast<float>(weight * std::sin(angle) * t * t);
    whole += weights[i];
  }
  for (float& weight : weights) weight = static_cast<float>(weight / whole);
  return legendreSums(cosines, weights);
}

double dot(const Moments& weights, const Moments& a, const Moments& b) {
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i) sum += weights[i] * a[i] * b[i];
  return sum;
}

// The candidate lobes.
struct Choices {
  Moments bands = bandWeights(), cosine = momentsOf(Lobe::Cosine, 1.0f);
  std::vector<Moments> levels;
  Choices() {
    levels.emplace_back().fill(1.0);  // the mirror
    for (size_t i = 1; i < kSpecularRoughness.size(); ++i)
      levels.push_back(momentsOf(Lobe::Specular, kSpecularRoughness[i] * kSpecularRoughness[i]));
  }
  double last() const { return static_cast<double>(levels.size() - 1); }
  Moments at(double level) const {
    const size_t lower = std::min(static_cast<size_t>(level), levels.size() - 2);
    Moments m;
    for (size_t i = 0; i < m.size(); ++i)
      m[i] = levels[lower][i] + (level - static_cast<double>(lower)) * (levels[lower + 1][i] - levels[lower][i]);
    return m;
  }
};

// The reference lobe, for a metal of reflectance 0.5, halfway between the two terms that shading mixes.
class TrueLobe {
 public:
  TrueLobe(float nv, float roughness) : samples_(ggxSamples(nv, roughness)) {
    double whole = 0;
    for (const GgxSample& s : samples_) whole += weights_.emplace_back(s.weight * (0.5f + 0.5f * s.grazing));
    for (float& weight : weights_) weight = static_cast<float>(weight / whole);
  }
  // Returns the moments about the direction (sine, 0, cosine).
  Moments moments(double sine, double cosine) const {
    std::vector<float> cosines;
    cosines.reserve(samples_.size());
    for (const GgxSample& s : samples_)
      cosines.push_back(s.toLight.x * static_cast<float>(sine) + s.toLight.z * static_cast<float>(cosine));
    return legendreSums(cosines, weights_);
  }

 private:
  std::vector<GgxSample> samples_;
  std::vector<float> weights_;
};

class Search {
 public:
  Search(const Choices& choices, float nv, float roughness)
      : choices_(choices), lobe_(nv, roughness), mirrorSine_(std::sqrt(1.0 - double{nv} * nv)) {
    aboutNormal_ = lobe_.moments(0, 1);
  }

  // Searches a coarse grid over lean and level, then finer grids around the best candidate.
  vec3 run() {
    constexpr int kLeans = 8, kLevels = 12;
    for (int pass = 0; pass < 4; ++pass) {
      const double leans = std::pow(0.25, pass), levels = choices_.last() * std::pow(0.3, pass);
      const double lean = pass > 0 ? best_.lean : 0.5, level = pass > 0 ? best_.level : choices_.last() * 0.5;
      for (int i = kLeans; i >= 0; --i) {
        const double k = std::clamp(lean + leans * (double(i) / kLeans - 0.5), 0.0, 1.0);
        const double sine = k * mirrorSine_, cosine = std::sqrt(1.0 - sine * sine);
        const Moments seen = lobe_.moments(sine, cosine);
        const Moments polynomials = legendreSums({static_cast<float>(cosine)}, {1.0f});
        for (int j = 0; j <= kLevels; ++j)
          consider(k, std::clamp(level + levels * (double(j) / kLevels - 0.5), 0.0, choices_.last()), seen,
                   polynomials);
      }
    }
    return vec3(best_.lean, best_.level, best_.wide);
  }

 private:
  // Computes the squared error, up to a constant, with the fraction of the cosine lobe that minimizes it.
  void consider(double lean, double level, const Moments& seen, const Moments& polynomials) {
    const Moments narrow = choices_.at(level);
    Moments between;
    for (size_t i = 0; i < between.size(); ++i) between[i] = narrow[i] * polynomials[i];
    const double narrowSquare = dot(choices_.bands, narrow, narrow);
    const double wideSquare = dot(choices_.bands, choices_.cosine, choices_.cosine);
    const double both = dot(choices_.bands, between, choices_.cosine);
    const double narrowTrue = dot(choices_.bands, narrow, seen);
    const double wideTrue = dot(choices_.bands, choices_.cosine, aboutNormal_);
    const double apart = narrowSquare - 2 * both + wideSquare;
    const double w = apart > 1e-9 ? std::clamp((narrowSquare - both - narrowTrue + wideTrue) / apart, 0.0, 1.0) : 0.0;
    const double error = (1 - w) * (1 - w) * narrowSquare + w * w * wideSquare + 2 * w * (1 - w) * both -
                         2 * (1 - w) * narrowTrue - 2 * w * wideTrue;
    if (error < best_.error) best_ = {lean, level, w, error};
  }

  struct Best {
    double lean = 1, level = 0, wide = 0, error = std::numeric_limits<double>::infinity();
  };
  const Choices& choices_;
  const TrueLobe lobe_;
  const double mirrorSine_;
  Moments aboutNormal_;
  Best best_;
};

std::vector<vec3> computeLobeTable(uint32_t size) {
  std::vector<vec3> table(size_t{size} * size);
  const Choices choices;
  const float step = 1.0f / static_cast<float>(size - 1);
  parallelFor(table.size(), 4, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float nv = std::max(static_cast<float>(i % size) * step, 1e-3f);
      table[i] = Search(choices, std::min(nv, 1.0f), static_cast<float>(i / size) * step).run();
    }
  });
  return table;
}

}  // namespace

std::vector<vec3> ggxLobeTable(uint32_t size) {
  return cachedTable<vec3>(fmt::format("ggx-lobe-{}-{}.bin", size, kLobeVersion), size_t{size} * size,
                           [&] { return computeLobeTable(size); });
}

}  // namespace latelight::scene
