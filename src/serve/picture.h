// Pictures on their way to a browser.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "view/state.h"

namespace latelight::serve {

// Rows of a picture as a JPEG file of their own: strips are made, and decoded, on all cores.
struct Strip {
  uint32_t y = 0, rows = 0;
  std::string jpeg;
};
// Transparent pixels are mixed with kBehind, since JPEG has none. `quality`: 1 to 100; from kFullColour on chroma has
// the picture's own resolution.
std::vector<Strip> encodeStrips(const view::Frame& frame, int quality);
constexpr uint8_t kBehind[3] = {24, 26, 30};
constexpr int kFullColour = 90;

size_t bytesOf(const std::vector<Strip>& strips);
// Enough for encodeStrips() and for a message with its strips: JPEG's upper bound, which is more than twice the size of
// noise, and a copy of the pixels.
uint64_t encodingBytes(const view::Frame& frame);

}  // namespace latelight::serve
