// Encoding of pictures for a browser.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "view/state.h"

namespace latelight::serve {

// Rows of a picture as a separate JPEG file, so that strips are encoded and decoded on all cores.
struct Strip {
  uint32_t y = 0, rows = 0;
  std::string jpeg;
};
// Transparent pixels are blended over kBehind, because JPEG has no alpha. `quality`: 1 to 100. From kFullColor on,
// chroma is not subsampled.
std::vector<Strip> encodeStrips(const view::SessionFrame& frame, int quality);
constexpr uint8_t kBehind[3] = {24, 26, 30};
constexpr int kFullColor = 90;

size_t bytesOf(const std::vector<Strip>& strips);
// An upper bound of the memory for encodeStrips() and a message with its strips: JPEG's upper bound, which is more than
// twice the size of noise, plus a copy of the pixels.
uint64_t encodingBytes(const view::SessionFrame& frame);

}  // namespace latelight::serve
