#include "serve/picture.h"

#include <turbojpeg.h>

#include <algorithm>
#include <memory>
#include <span>

#include "base/error.h"
#include "base/parallel.h"

namespace latelight::serve {

namespace {

// A multiple of JPEG's blocks of 16 rows, so that strips look like one picture. A thread is not worthwhile for fewer
// rows.
constexpr uint32_t kMinRows = 128;

uint32_t rowsOfStrip(uint32_t height) {
  const auto threads = static_cast<uint32_t>(threadCount());
  const uint32_t shared = (height + threads - 1) / threads;
  return std::max(kMinRows, (shared + 15) / 16 * 16);
}

bool isOpaque(std::span<const uint8_t> rgba) {
  for (size_t i = 3; i < rgba.size(); i += 4)
    if (rgba[i] != 255) return false;
  return true;
}

std::vector<uint8_t> overGround(std::span<const uint8_t> rgba) {
  std::vector<uint8_t> opaque(rgba.begin(), rgba.end());
  for (size_t i = 0; i < opaque.size(); i += 4)
    for (size_t c = 0; c < 3; ++c)
      opaque[i + c] = static_cast<uint8_t>((rgba[i + c] * rgba[i + 3] + kBehind[c] * (255 - rgba[i + 3]) + 127) / 255);
  return opaque;
}

// The encoder enlarges its buffer as the file grows.
std::string encodeJpeg(std::span<const uint8_t> rgba, uint32_t width, uint32_t rows, int quality) {
  const std::unique_ptr<void, int (*)(void*)> encoder(tjInitCompress(), tjDestroy);
  const int chroma = quality >= kFullColor ? TJSAMP_444 : TJSAMP_420;
  unsigned char* file = nullptr;
  unsigned long bytes = 0;
  const bool encoded =
      encoder && tjCompress2(encoder.get(), rgba.data(), static_cast<int>(width), 0, static_cast<int>(rows), TJPF_RGBX,
                             &file, &bytes, chroma, quality, TJFLAG_FASTDCT) == 0;
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(file, tjFree);
  if (!encoded) fail(ExitCode::Internal, "a picture could not be encoded: {}", tjGetErrorStr2(encoder.get()));
  return {reinterpret_cast<const char*>(file), bytes};
}

// Opaque pixels are encoded in place, without a copy.
std::string encodeStrip(const view::SessionFrame& frame, const Strip& strip, int quality) {
  const size_t row = size_t{4} * frame.width;
  const auto rgba = std::span(frame.rgba).subspan(row * strip.y, row * strip.rows);
  if (isOpaque(rgba)) return encodeJpeg(rgba, frame.width, strip.rows, quality);
  return encodeJpeg(overGround(rgba), frame.width, strip.rows, quality);
}

}  // namespace

std::vector<Strip> encodeStrips(const view::SessionFrame& frame, int quality) {
  const uint32_t rows = rowsOfStrip(frame.height);
  std::vector<Strip> strips;
  for (uint32_t y = 0; y < frame.height; y += rows) strips.push_back({y, std::min(rows, frame.height - y), {}});
  parallelFor(strips.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) strips[i].jpeg = encodeStrip(frame, strips[i], quality);
  });
  return strips;
}

uint64_t encodingBytes(const view::SessionFrame& frame) {
  return tjBufSize(static_cast<int>(frame.width), static_cast<int>(frame.height), TJSAMP_444) + frame.rgba.size();
}

size_t bytesOf(const std::vector<Strip>& strips) {
  size_t bytes = 0;
  for (const Strip& strip : strips) bytes += strip.jpeg.size();
  return bytes;
}

}  // namespace latelight::serve
