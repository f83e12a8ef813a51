// Converts the values of an AOV to those of a PNG file, with one function per PngCoding.
#include <algorithm>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "output/png.h"
#include "output/srgb.h"

namespace latelight::output {
namespace {

constexpr size_t kGrain = size_t{1} << 16;

// Calls each(i) for i in [0, count) on all threads.
template <typename F>
void forEach(size_t count, F&& each) {
  parallelFor(count, kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) each(i);
  });
}

// Without branches, which normals make unpredictable. NaN becomes 0.
uint16_t unorm16(float value) {
  const float positive = value > 0 ? value : 0.0f;
  const float clamped = positive < 1 ? positive : 1.0f;
  return static_cast<uint16_t>(static_cast<int32_t>(clamped * 65535 + 0.5f));
}

uint16_t millimetres(float metres) {
  if (!(metres > 0) || std::isinf(metres)) return 0;
  if (metres >= 65.535f) return 65535;
  return static_cast<uint16_t>(std::max(1.0, std::floor(static_cast<double>(metres) * 1000 + 0.5)));
}

uint16_t countOf(float count) {
  return count > 0 ? static_cast<uint16_t>(std::min(count, 65535.0f) + 0.5f) : 0;
}

std::vector<uint8_t> displayOf(const AovImage& color) {
  std::vector<uint8_t> rgba(color.values.size());
  forEach(rgba.size() / 4, [&](size_t i) {
    const float* in = &color.values[4 * i];
    const float scale = in[3] > 0 ? 1 / in[3] : 0;
    for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = srgb8(in[c] * scale);
    rgba[4 * i + 3] = unorm8(in[3]);
  });
  return rgba;
}

std::vector<uint8_t> srgbOf(const AovImage& image) {
  std::vector<uint8_t> rgb(image.values.size());
  forEach(rgb.size(), [&](size_t i) { rgb[i] = srgb8(image.values[i]); });
  return rgb;
}

template <typename Code>
std::vector<uint16_t> codeEach(const AovImage& image, Code&& code) {
  std::vector<uint16_t> out(image.values.size());
  forEach(out.size(), [&](size_t i) { out[i] = code(image.values[i]); });
  return out;
}

std::vector<uint16_t> signedOf(const AovImage& image) {
  std::vector<uint16_t> out(image.values.size(), 0);
  forEach(out.size() / 3, [&](size_t i) {
    const float* n = &image.values[3 * i];
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) return;
    for (size_t c = 0; c < 3; ++c) out[3 * i + c] = unorm16(n[c] * 0.5f + 0.5f);
  });
  return out;
}

std::vector<uint16_t> fractionsOf(const AovImage& image) {
  std::vector<uint16_t> out(image.values.size() / 2 * 3, 0);
  forEach(out.size() / 3, [&](size_t i) {
    for (size_t c = 0; c < 2; ++c) {
      const float value = image.values[2 * i + c];
      out[3 * i + c] = unorm16(value - std::floor(value));
    }
  });
  return out;
}

template <typename T>
std::vector<std::byte> encode(const AovImage& image, const std::vector<T>& pixels, PngLight light) {
  const size_t count = size_t{image.width} * image.height;
  return encodePng(image.width, image.height, static_cast<uint32_t>(pixels.size() / count), sizeof(T) * 8,
                   reinterpret_cast<const std::byte*>(pixels.data()), light);
}

}  // namespace

std::vector<std::byte> encodePng(const AovImage& image) {
  switch (info(image.aov).png) {
    case PngCoding::None:
      break;
    case PngCoding::Display:
      return encode(image, displayOf(image), PngLight::Srgb);
    case PngCoding::Srgb:
      return encode(image, srgbOf(image), PngLight::Srgb);
    case PngCoding::Unit:
      return encode(image, codeEach(image, unorm16), PngLight::Data);
    case PngCoding::Signed:
      return encode(image, signedOf(image), PngLight::Data);
    case PngCoding::Millimetre:
      return encode(image, codeEach(image, millimetres), PngLight::Data);
    case PngCoding::Fraction:
      return encode(image, fractionsOf(image), PngLight::Data);
    case PngCoding::Count:
      return encode(image, codeEach(image, countOf), PngLight::Data);
    case PngCoding::IdBytes:
      static_assert(std::endian::native == std::endian::little);  // the lowest byte of an id is red
      return encodePng(image.width, image.height, 4, 8, reinterpret_cast<const std::byte*>(image.ids.data()),
                       PngLight::Data);
  }
  fail(ExitCode::Internal, "{} has no PNG coding", info(image.aov).name);
}

}  // namespace latelight::output
