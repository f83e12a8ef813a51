#include "base/error.h"
#include "data/cameras/calibrated.h"
#include "data/cameras/cameras.h"
#include "data/cameras/source.h"

namespace latelight::data {

void CameraBudget::take(double count, double nameBytes, const std::string& path) {
  // While a job's camera is created, its shot, the shot of its rig's base camera and a camera read from a file exist at
  // the same time. The capacity of lists may be twice their length.
  constexpr double kWorkingBytes = 3 * sizeof(Shot) + sizeof(CalibratedCamera) + 128,
                   kResultBytes = 2 * sizeof(JobCamera);
  count_ += count;
  if (count_ > double(kMaxCamerasOfScene))
    badUsage("{}: there are more than {} cameras in all: make fewer", path, kMaxCamerasOfScene);
  working_.grow(static_cast<uint64_t>(count * kWorkingBytes + 3 * nameBytes), "the making of the job's cameras");
  kept_.grow(static_cast<uint64_t>(count * kResultBytes + 2 * nameBytes), "the job's cameras");
}

}  // namespace latelight::data
