// Conversion between floats and half floats (IEEE 754 binary16), rounded to nearest, ties to even: with F16C if the
// processor supports it, otherwise with Imath. Both produce the same bits for every float, except for the payloads of
// NaNs.
#pragma once

#include <Imath/half.h>

#include <cstddef>
#include <cstdint>

#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>
#endif

namespace latelight::scene {

inline constexpr float kHalfMax = 65504.0f;

// Values above 65519.99 become infinity.
inline uint16_t halfFromFloat(float value) {
  return imath_float_to_half(value);
}

inline float floatFromHalf(uint16_t half) {
  return imath_half_to_float(half);
}

namespace detail {

#if defined(__x86_64__)
__attribute__((target("avx,f16c"))) inline size_t halvesFromFloatsF16c(const float* from, uint16_t* to, size_t count) {
  size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    const __m128i halves = _mm256_cvtps_ph(_mm256_loadu_ps(from + i), _MM_FROUND_TO_NEAREST_INT);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to + i), halves);
  }
  return i;
}

__attribute__((target("avx,f16c"))) inline size_t floatsFromHalvesF16c(const uint16_t* from, float* to, size_t count) {
  size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    _mm256_storeu_ps(to + i, _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from + i))));
  }
  return i;
}

// By CPUID, because __builtin_cpu_supports() knows no "f16c" before Clang 18. Its "avx" includes that the operating
// system saves the registers.
inline bool hasF16c() {
  static const bool has = [] {
    unsigned a = 0, b = 0, c = 0, d = 0;
    return __builtin_cpu_supports("avx") && __get_cpuid(1, &a, &b, &c, &d) && (c & bit_F16C) != 0;
  }();
  return has;
}
#endif

}  // namespace detail

inline void halvesFromFloats(const float* from, uint16_t* to, size_t count) {
  size_t i = 0;
#if defined(__x86_64__)
  if (detail::hasF16c()) i = detail::halvesFromFloatsF16c(from, to, count);
#endif
  for (; i < count; ++i) to[i] = halfFromFloat(from[i]);
}

inline void floatsFromHalves(const uint16_t* from, float* to, size_t count) {
  size_t i = 0;
#if defined(__x86_64__)
  if (detail::hasF16c()) i = detail::floatsFromHalvesF16c(from, to, count);
#endif
  for (; i < count; ++i) to[i] = floatFromHalf(from[i]);
}

}  // namespace latelight::scene
