// Elementary functions that use only IEEE additions, multiplications, divisions and square roots, which round
// identically on every machine. The functions of libm differ in the last bit between versions and machines, and
// built-in scenes, cameras and ray patterns must not. The accuracy is about 1e-13, far better than geometry in floats
// requires.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vec2.hpp>

namespace latelight::exact {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kTau = 2 * kPi;

namespace detail {
// Taylor series for |x| <= pi / 4.
inline double sinSmall(double x) {
  const double s = x * x;
  return x * (1 - s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110 * (1 - s / 156 * (1 - s / 210)))))));
}
inline double cosSmall(double x) {
  const double s = x * x;
  return 1 - s / 2 * (1 - s / 12 * (1 - s / 30 * (1 - s / 56 * (1 - s / 90 * (1 - s / 132 * (1 - s / 182))))));
}
}  // namespace detail

// Sine of an angle in quarter turns. It is exact at multiples of a quarter turn, so that four-fold symmetry is exact
// too.
inline double sinQuarters(double q) {
  const double nearest = std::floor(q + 0.5);
  const double x = (q - nearest) * (kPi / 2);
  switch (static_cast<int64_t>(nearest) & 3) {
    case 0:
      return detail::sinSmall(x);
    case 1:
      return detail::cosSmall(x);
    case 2:
      return -detail::sinSmall(x);
    default:
      return -detail::cosSmall(x);
  }
}
inline double cosQuarters(double q) {
  return sinQuarters(q + 1);
}

// Angles in radians.
inline double sine(double x) {
  return sinQuarters(x * (2 / kPi));
}
inline double cosine(double x) {
  return cosQuarters(x * (2 / kPi));
}

// The point on the unit circle at an angle in full turns.
inline glm::dvec2 onCircle(double turns) {
  return {cosQuarters(turns * 4), sinQuarters(turns * 4)};
}

inline double exponential2(double x) {
  const double whole = std::floor(x + 0.5);
  const double y = (x - whole) * 0.69314718055994530942;
  double sum = 1;
  for (int k = 14; k >= 1; --k) sum = 1 + y / k * sum;
  return std::ldexp(sum, static_cast<int>(whole));
}

// Requires x > 0. Uses log2(m) = 2 atanh((m - 1) / (m + 1)) / ln 2 with m in [sqrt(1/2), sqrt(2)].
inline double logarithm2(double x) {
  int exponent = 0;
  double m = std::frexp(x, &exponent);
  if (m < 0.70710678118654752440) {
    m *= 2;
    --exponent;
  }
  const double t = (m - 1) / (m + 1), s = t * t;
  double sum = 0;
  for (int k = 23; k >= 1; k -= 2) sum = sum * s + 1.0 / k;
  return exponent + 2 * t * sum * 1.44269504088896340736;
}

// Requires x >= 0.
inline double power(double x, double y) {
  return x > 0 ? exponential2(y * logarithm2(x)) : 0.0;
}

inline double exponential(double x) {
  return exponential2(x * 1.44269504088896340736);
}

// Returns the angle of (x, y) in turns, in [0, 1).
inline double turnsOf(double y, double x) {
  const double ax = std::abs(x), ay = std::abs(y);
  if (ax + ay == 0) return 0;
  double t = std::min(ax, ay) / std::max(ax, ay);
  // Halve the angle twice for a fast series: tan(a/2) = t / (1 + sqrt(1 + t^2)).
  t = t / (1 + std::sqrt(1 + t * t));
  t = t / (1 + std::sqrt(1 + t * t));
  const double s = t * t;
  double sum = 0;
  for (int k = 21; k >= 1; k -= 2) sum = 1.0 / k - s * sum;
  double a = 4 * t * sum / kTau;
  if (ay > ax) a = 0.25 - a;
  if (x < 0) a = 0.5 - a;
  if (y < 0) a = 1 - a;
  return a < 1 ? a : 0;
}

}  // namespace latelight::exact
