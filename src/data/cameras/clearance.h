// Rejects camera positions that are inside geometry or too near to it.
#pragma once

#include <optional>

#include "data/cameras/source.h"
#include "data/cameras/surroundings.h"

namespace latelight::data {

class Clearance {
 public:
  // Reads the keys "rejectInside" and "clearance".
  Clearance(Spec& spec, const CameraContext& context);
  bool allows(glm::dvec3 eye) const;

 private:
  bool rejectInside_;
  double clearance_;
  std::optional<Surroundings> surroundings_;
};

// The maximum number of random positions tried per camera.
inline constexpr uint32_t kTries = 1000;
// Throws Error(Usage): only `found` of `count` cameras have an accepted position.
[[noreturn]] void failWithoutPosition(const Spec& spec, uint64_t found, uint64_t count);

}  // namespace latelight::data
