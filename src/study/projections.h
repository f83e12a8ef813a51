// The projections used by the studies of depth and position.
#pragma once

#include <string>
#include <vector>

#include "shared/projection.h"

namespace latelight::study {

inline constexpr double kNear = 0.1, kFar = 1000;  // meters; kFar also limits samples if there is no far plane

struct NamedProjection {
  std::string name;
  shared::Projection projection;
};

// Conventional and reversed depth, with a far plane and, for perspective, also without one.
std::vector<NamedProjection> perspectives();
std::vector<NamedProjection> orthographics();

}  // namespace latelight::study
