// Which places are fit for a camera: not inside geometry, and not too near to it.
#pragma once

#include <optional>

#include "data/cameras/source.h"
#include "data/cameras/surroundings.h"

namespace latelight::data {

class Clearance {
 public:
  // "rejectInside" and "clearance".
  Clearance(Spec& spec, const CameraContext& context);
  bool allows(glm::dvec3 eye) const;

 private:
  bool rejectInside_;
  double clearance_;
  std::optional<Surroundings> surroundings_;
};

// How often a place is drawn before a camera is given up.
inline constexpr uint32_t kTries = 1000;
[[noreturn]] void failWithoutPlace(const Spec& spec, uint64_t found, uint64_t count);

}  // namespace latelight::data
