#include "render/gpu_scene/ltc_table.h"

#include <algorithm>
#include <cmath>

namespace latelight::render {

namespace {

constexpr shared::LtcFit kTable[] = {
#include "render/gpu_scene/ltc_table.inc"
};
static_assert(std::size(kTable) == shared::kLtcSize * shared::kLtcSize);

shared::LtcFit mixed(const shared::LtcFit& p, const shared::LtcFit& q, float t) {
  return {std::lerp(p.a, q.a, t), std::lerp(p.b, q.b, t), std::lerp(p.c, q.c, t), std::lerp(p.d, q.d, t)};
}

}  // namespace

std::span<const shared::LtcFit> ltcTable() {
  return kTable;
}

shared::LtcFit lobeFit(float nv, float roughness) {
  constexpr auto kLast = static_cast<float>(shared::kLtcSize - 1);
  const float row = std::clamp(roughness, 0.0f, 1.0f) * kLast;
  const float column = std::sqrt(std::clamp(1 - nv, 0.0f, 1.0f)) * kLast;
  const uint32_t low = std::min(static_cast<uint32_t>(row), shared::kLtcSize - 2);
  const uint32_t left = std::min(static_cast<uint32_t>(column), shared::kLtcSize - 2);
  const shared::LtcFit* at = &kTable[low * shared::kLtcSize + left];
  const float across = column - static_cast<float>(left);
  return mixed(mixed(at[0], at[1], across), mixed(at[shared::kLtcSize], at[shared::kLtcSize + 1], across),
               row - static_cast<float>(low));
}

}  // namespace latelight::render
