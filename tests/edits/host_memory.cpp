#include "edits/host_memory.h"

#include <malloc.h>

#include <algorithm>
#include <vector>

namespace latelight::render::test {

size_t leastHostBytes(const std::function<void()>& frame) {
  size_t least = ~size_t{0};
  for (int again = 0; again < 8; ++again) {
    frame();
    const auto host = mallinfo2();
    least = std::min(least, host.uordblks + host.hblkhd);
  }
  return least;
}

double steadyGrowth(std::span<const size_t> bytes) {
  std::vector<double> growth;
  for (size_t i = 1; i < bytes.size(); ++i)
    growth.push_back(static_cast<double>(bytes[i]) - static_cast<double>(bytes[i - 1]));
  const auto quartile = growth.begin() + growth.size() / 4;
  std::ranges::nth_element(growth, quartile);
  return *quartile;
}

}  // namespace latelight::render::test
