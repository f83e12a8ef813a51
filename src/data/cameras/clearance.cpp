#include "data/cameras/clearance.h"

#include "base/error.h"
#include "data/stop.h"

namespace latelight::data {

Clearance::Clearance(Spec& spec, const CameraContext& context)
    : rejectInside_(spec.flag("rejectInside", true)), clearance_(spec.number("clearance", kNotNegative, 0.0)) {
  if (rejectInside_ || clearance_ > 0) surroundings_.emplace(context.scene);
}

bool Clearance::allows(glm::dvec3 eye) const {
  throwIfStopped();
  if (clearance_ > 0 && surroundings_->nearest(eye, clearance_) < clearance_) return false;
  return !rejectInside_ || !surroundings_->inside(eye);
}

void failWithoutPosition(const Spec& spec, uint64_t found, uint64_t count) {
  badUsage("{}: found places for {} of {} cameras only, with {} tries for the next: lower \"clearance\", or move them",
           spec.path(), found, count, kTries);
}

}  // namespace latelight::data
