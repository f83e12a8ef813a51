#include "study/projections.h"

#include <cmath>
#include <numbers>

namespace latelight::study {

namespace {

constexpr double kAspect = 16.0 / 9.0;

shared::Projection make(double V, double A, double B, uint32_t kind) {
  shared::Projection p{};
  p.H = static_cast<float>(V / kAspect);
  p.V = static_cast<float>(V);
  p.A = static_cast<float>(A);
  p.B = static_cast<float>(B);
  p.kind = kind;
  return p;
}

}  // namespace

std::vector<NamedProjection> perspectives() {
  const double V = 1 / std::tan(std::numbers::pi / 6);  // vertical field of view 60 degrees
  const double range = kFar - kNear;
  const auto perspective = [&](double A, double B) { return make(V, A, B, shared::kPerspective); };
  return {{"conventional", perspective(kFar / range, -kNear * kFar / range)},
          {"reversed", perspective(-kNear / range, kNear * kFar / range)},
          {"conventional infinite", perspective(1, -kNear)},
          {"reversed infinite", perspective(0, kNear)}};
}

std::vector<NamedProjection> orthographics() {
  const double V = 1 / 20.0;  // height 40 m
  const double range = kFar - kNear;
  return {{"orthographic conventional", make(V, 1 / range, -kNear / range, shared::kOrthographic)},
          {"orthographic reversed", make(V, -1 / range, kFar / range, shared::kOrthographic)}};
}

}  // namespace latelight::study
