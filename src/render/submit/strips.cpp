#include "render/submit/strips.h"

#include "render/outputs/outputs.h"

#include <algorithm>

namespace latelight::render {

namespace {

// A multiple of the side of every pixel block that passes process: 2 for derivatives, 16 for workgroups and tiles.
constexpr uint32_t kBlock = 64;

bool needsNeighbours(const Settings& s, bool transmissive) {
  return showsPicture(s) &&
         (transmissive || s.aa.temporal || s.aa.fxaa || s.bloom > 0 || s.ambientOcclusion != AmbientOcclusion::None ||
          (s.indirect != Indirect::None && s.indirectFilter != IndirectFilter::None));
}

// With more than four samples per pixel, strips have a constant number of samples instead of pixels.
uint32_t stripPixels(const Settings& s) {
  return showsPicture(s) ? s.stripPixels / (std::max(s.aa.samples, 4u) / 4) : s.stripPixels;
}

template <typename T>
void append(std::vector<T>& whole, const std::vector<T>& strip, size_t most) {
  whole.reserve(most);
  whole.insert(whole.end(), strip.begin(), strip.end());
}

}  // namespace

std::vector<Strip> stripsOf(const Settings& s, bool transmissive) {
  const uint32_t pixels = stripPixels(s);
  if (uint64_t{s.width} * s.height <= pixels || needsNeighbours(s, transmissive)) return {{0, s.height}};
  const uint32_t blocks = std::max<uint32_t>(1, pixels / (s.width * kBlock));
  const uint32_t rows = blocks * kBlock;
  std::vector<Strip> strips;
  for (uint32_t first = 0; first < s.height; first += rows) strips.push_back({first, std::min(rows, s.height - first)});
  return strips;
}

// The NDC of a strip is that of the full picture, scaled by `times` and offset.
shared::View viewOf(const shared::View& whole, Strip strip) {
  const double height = whole.size.y, rows = strip.rows, times = height / rows;
  shared::View view = whole;
  view.size.y = static_cast<float>(rows);
  view.projection.V = static_cast<float>(whole.projection.V * times);
  view.projection.Z = static_cast<float>(whole.projection.Z * times + (rows - height + 2.0 * strip.first) / rows);
  view.jitter.y = static_cast<float>(whole.jitter.y * times);
  return view;
}

void append(output::FrameOutput& whole, const output::FrameOutput& strip) {
  const size_t pixels = size_t{whole.width} * whole.height;
  if (!strip.display.empty()) append(whole.display, strip.display, 4 * pixels);
  for (size_t i = 0; i < whole.aovs.size(); ++i) {
    const output::AovImage& from = strip.aovs[i];
    if (!from.values.empty()) append(whole.aovs[i].values, from.values, pixels * output::info(from.aov).channels);
    if (!from.ids.empty()) append(whole.aovs[i].ids, from.ids, pixels);
  }
}

}  // namespace latelight::render
