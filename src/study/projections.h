// The projections used by the studies of depth and position.
#pragma once

#include <string>
#include <vector>

#include "shared/projection.h"

namespace latelight::study {

inline constexpr double kNear = 0.1, kFar = 1000;  // metres; also limits the samples where the far plane is at infinity

struct NamedProjection {
  std::string name;
  shared::Projection projection;
};

// Conventional and reversed; with a far plane and, for perspective, without.
std::vector<NamedProjection> perspectives();
std::vector<NamedProjection> orthographics();

}  // namespace latelight::study
