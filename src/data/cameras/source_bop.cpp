// The camera source "bop": cameras of a scene_camera.json of BOP.
#include "base/error.h"
#include "data/cameras/bop.h"

namespace latelight::data {

std::vector<Shot> shotsOfBop(Spec& spec, const CameraContext& context) {
  const PictureSize size = readSize(spec, context.size);
  if (size.width == 0)
    badUsage("{} needs \"size\", here or among the job's options: scene_camera.json does not say it", spec.path());
  std::vector<Shot> shots = placeCameras(spec, context, readBop(spec.text("file"), size));
  makeSequence(shots);
  return shots;
}

}  // namespace latelight::data
