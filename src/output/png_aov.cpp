// Converts the values of an AOV to those of a PNG file, with one function per PngCoding.
#include <algorithm>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "output/png.h"
#include "output/srgb.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace latelight::output {
namespace {

// NaN becomes 0.
uint16_t unorm16(float value) {
  const float positive = value > 0 ? value : 0.0f;
  const float clamped = positive < 1 ? positive : 1.0f;
  return static_cast<uint16_t>(static_cast<int32_t>(clamped * 65535 + 0.5f));
}

// Sets out[i] = unorm16(values[i] * scale + offset). Compilers do not find the minimum and maximum by themselves,
// because of NaN.
void unorm16(const float* values, size_t count, float scale, float offset, uint16_t* out) {
  size_t i = 0;
#ifdef __SSE2__
  const auto convert = [&](const float* from) {
    const __m128 value = _mm_add_ps(_mm_mul_ps(_mm_loadu_ps(from), _mm_set1_ps(scale)), _mm_set1_ps(offset));
    const __m128 clamped = _mm_min_ps(_mm_max_ps(value, _mm_setzero_ps()), _mm_set1_ps(1));
    const __m128 code = _mm_add_ps(_mm_mul_ps(clamped, _mm_set1_ps(65535)), _mm_set1_ps(0.5f));
    return _mm_sub_epi32(_mm_cvttps_epi32(code), _mm_set1_epi32(32768));  // signed, to be packed
  };
  for (; i + 8 <= count; i += 8) {
    const __m128i packed = _mm_packs_epi32(convert(values + i), convert(values + i + 4));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + i), _mm_xor_si128(packed, _mm_set1_epi16(-32768)));
  }
#endif
  for (; i < count; ++i) out[i] = unorm16(values[i] * scale + offset);
}

uint16_t millimetres(float meters) {
  if (!(meters > 0) || std::isinf(meters)) return 0;
  if (meters >= 65.535f) return 65535;
  return static_cast<uint16_t>(std::max(1.0, std::floor(static_cast<double>(meters) * 1000 + 0.5)));
}

uint16_t countOf(float count) {
  return count > 0 ? static_cast<uint16_t>(std::min(count, 65535.0f) + 0.5f) : 0;
}

void displayOf(const float* rgba, size_t pixels, uint8_t* out) {
  for (size_t i = 0; i < pixels; ++i, rgba += 4, out += 4) {
    const float scale = rgba[3] > 0 ? 1 / rgba[3] : 0;
    for (size_t c = 0; c < 3; ++c) out[c] = srgb8(rgba[c] * scale);
    out[3] = unorm8(rgba[3]);
  }
}

void signedOf(const float* normals, size_t pixels, uint16_t* out) {
  unorm16(normals, 3 * pixels, 0.5f, 0.5f, out);
  constexpr uint16_t kZero = 32768;  // of n * 0.5 + 0.5, which no pixel has in all channels but those of background
  for (size_t i = 0; i < 3 * pixels; i += 3)
    if (((out[i] ^ kZero) | (out[i + 1] ^ kZero) | (out[i + 2] ^ kZero)) == 0 && normals[i] == 0 &&
        normals[i + 1] == 0 && normals[i + 2] == 0)
      out[i] = out[i + 1] = out[i + 2] = 0;
}

void fractionsOf(const float* uv, size_t pixels, uint16_t* out) {
  for (size_t i = 0; i < pixels; ++i, uv += 2, out += 3) {
    for (size_t c = 0; c < 2; ++c) out[c] = unorm16(uv[c] - std::floor(uv[c]));
    out[2] = 0;
  }
}

// Encodes with convert(values, pixels, out), which writes `channels` values of the type T per pixel.
template <typename T, typename Convert>
std::vector<std::byte> encode(const AovImage& image, uint32_t channels, PngLight light, Convert&& convert) {
  const PngLayout layout{image.width, image.height, channels, sizeof(T) * 8, light};
  const size_t rowValues = size_t{image.width} * info(image.aov).channels;
  return encodePng(layout, [&](size_t begin, size_t end, std::byte* out) {
    convert(image.values.data() + begin * rowValues, (end - begin) * image.width, reinterpret_cast<T*>(out));
  });
}

// Encodes each value with code(value).
template <typename T, typename Code>
std::vector<std::byte> encodeEach(const AovImage& image, PngLight light, Code&& code) {
  const uint32_t channels = info(image.aov).channels;
  return encode<T>(image, channels, light, [&](const float* values, size_t pixels, T* out) {
    for (size_t i = 0; i < pixels * channels; ++i) out[i] = code(values[i]);
  });
}

}  // namespace

std::vector<std::byte> encodePng(const AovImage& image) {
  switch (info(image.aov).png) {
    case PngCoding::None:
      break;
    case PngCoding::Display:
      return encode<uint8_t>(image, 4, PngLight::Srgb, displayOf);
    case PngCoding::Srgb:
      return encodeEach<uint8_t>(image, PngLight::Srgb, [](float value) { return srgb8(value); });
    case PngCoding::Unit:
      return encode<uint16_t>(image, info(image.aov).channels, PngLight::Data,
                              [&](const float* values, size_t pixels, uint16_t* out) {
                                unorm16(values, pixels * info(image.aov).channels, 1, 0, out);
                              });
    case PngCoding::Signed:
      return encode<uint16_t>(image, 3, PngLight::Data, signedOf);
    case PngCoding::Millimetre:
      return encodeEach<uint16_t>(image, PngLight::Data, [](float value) { return millimetres(value); });
    case PngCoding::Fraction:
      return encode<uint16_t>(image, 3, PngLight::Data, fractionsOf);
    case PngCoding::Count:
      return encodeEach<uint16_t>(image, PngLight::Data, [](float value) { return countOf(value); });
    case PngCoding::IdBytes:
      static_assert(std::endian::native == std::endian::little);  // the lowest byte of an id is red
      return encodePng(image.width, image.height, 4, 8, reinterpret_cast<const std::byte*>(image.ids.data()),
                       PngLight::Data);
  }
  fail(ExitCode::Internal, "{} has no PNG coding", info(image.aov).name);
}

}  // namespace latelight::output
