#include "serve/picture.h"

#include <turbojpeg.h>

#include <algorithm>
#include <memory>

#include "base/error.h"
#include "base/parallel.h"

namespace latelight::serve {

namespace {

// A multiple of JPEG's blocks of 16 rows, so that strips look like one picture; fewer rows are not worth a thread.
constexpr uint32_t kLeastRows = 128;

uint32_t rowsOfStrip(uint32_t height) {
  const auto threads = static_cast<uint32_t>(threadCount());
  const uint32_t shared = (height + threads - 1) / threads;
  return std::max(kLeastRows, (shared + 15) / 16 * 16);
}

std::vector<uint8_t> withoutAlpha(const view::Frame& frame, const Strip& strip) {
  std::vector<uint8_t> rgb(size_t{3} * frame.width * strip.rows);
  const uint8_t* from = &frame.rgba[size_t{4} * frame.width * strip.y];
  for (uint8_t* to = rgb.data(); to != rgb.data() + rgb.size(); to += 3, from += 4)
    for (int c = 0; c < 3; ++c)
      to[c] = static_cast<uint8_t>((from[c] * from[3] + kBehind[c] * (255 - from[3]) + 127) / 255);
  return rgb;
}

std::string encodeJpeg(const std::vector<uint8_t>& rgb, uint32_t width, uint32_t rows, int quality) {
  const std::unique_ptr<void, int (*)(void*)> encoder(tjInitCompress(), tjDestroy);
  const int chroma = quality >= kFullColour ? TJSAMP_444 : TJSAMP_420;
  const int w = static_cast<int>(width), h = static_cast<int>(rows);
  std::string jpeg(tjBufSize(w, h, chroma), '\0');
  auto* to = reinterpret_cast<unsigned char*>(jpeg.data());
  unsigned long bytes = jpeg.size();
  if (!encoder || tjCompress2(encoder.get(), rgb.data(), w, 0, h, TJPF_RGB, &to, &bytes, chroma, quality,
                              TJFLAG_NOREALLOC | TJFLAG_FASTDCT) != 0)
    fail(ExitCode::Internal, "a picture could not be encoded: {}", tjGetErrorStr2(encoder.get()));
  jpeg.resize(bytes);
  return jpeg;
}

}  // namespace

std::vector<Strip> encodeStrips(const view::Frame& frame, int quality) {
  const uint32_t rows = rowsOfStrip(frame.height);
  std::vector<Strip> strips;
  for (uint32_t y = 0; y < frame.height; y += rows) strips.push_back({y, std::min(rows, frame.height - y), {}});
  parallelFor(strips.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      strips[i].jpeg = encodeJpeg(withoutAlpha(frame, strips[i]), frame.width, strips[i].rows, quality);
  });
  return strips;
}

size_t bytesOf(const std::vector<Strip>& strips) {
  size_t bytes = 0;
  for (const Strip& strip : strips) bytes += strip.jpeg.size();
  return bytes;
}

}  // namespace latelight::serve
