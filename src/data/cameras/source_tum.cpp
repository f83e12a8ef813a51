// The camera source "tum": the poses of a trajectory in TUM's format, sorted by time.
#include <algorithm>

#include "base/text.h"
#include "data/cameras/tum.h"

namespace latelight::data {

std::vector<Shot> shotsOfTum(Spec& spec, const CameraContext& context) {
  std::vector<CalibratedCamera> cameras = readTum(spec.text("file"));
  const auto timeOf = [](const CalibratedCamera& camera) { return parseNumber<double>(camera.name).value_or(0); };
  std::ranges::stable_sort(cameras, {}, timeOf);
  std::vector<double> times;
  for (const CalibratedCamera& camera : cameras) times.push_back(timeOf(camera));
  std::vector<Shot> shots = placeCameras(spec, context, cameras);
  makeSequence(shots, times);
  return shots;
}

}  // namespace latelight::data
