// Dynamic resolution: selects the divisor of width and height from the measured time of the last draft.
#include "view/draft.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace latelight::view {

namespace {

constexpr double kMax = 0.085;  // seconds per picture; the rest of 0.1 s is for display
constexpr double kDivisors[] = {1, 1.5, 2, 3, 4, 6, 8};

uint32_t divided(uint32_t pixels, double divisor) {
  return std::max<uint32_t>(1, static_cast<uint32_t>(std::lround(pixels / divisor)));
}

}  // namespace

Draft::Draft(bool slow) : divisor_(slow ? 4 : 1) {}

render::Settings Draft::of(const render::Settings& whole) const {
  render::Settings draft = whole;
  draft.width = divided(whole.width, divisor_);
  draft.height = divided(whole.height, divisor_);
  if (divisor_ > 1) draft.aa.superSampling = 1;
  if (means_ >= WithoutShadows) draft.shadows = render::ShadowFormat::None;
  if (means_ >= InCompute && whole.aa.samples == 1) draft.raster = render::Raster::Compute;
  return draft;
}

// Assumes that time is proportional to the number of pixels. This overestimates the time at a higher resolution, which
// prevents oscillation.
bool Draft::took(double seconds) {
  const std::pair before(divisor_, means_);
  const auto divisor = std::find_if(std::begin(kDivisors), std::end(kDivisors),
                                    [&](double d) { return seconds * (divisor_ / d) * (divisor_ / d) <= kMax; });
  if (divisor != std::end(kDivisors))
    divisor_ = *divisor;
  else if (divisor_ < kDivisors[std::size(kDivisors) - 1])
    divisor_ = kDivisors[std::size(kDivisors) - 1];
  else if (means_ < InCompute)
    means_ = static_cast<Means>(means_ + 1);
  return before != std::pair(divisor_, means_);
}

}  // namespace latelight::view
