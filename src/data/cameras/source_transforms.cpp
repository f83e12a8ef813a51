// The camera source "transforms": the frames of a transforms.json of nerfstudio or instant-ngp.
#include "data/cameras/transforms.h"

namespace latelight::data {

std::vector<Shot> shotsOfTransforms(Spec& spec, const CameraContext& context) {
  const PictureSize size = readSize(spec, context.size);
  std::vector<Shot> shots = placeCameras(spec, context, readTransforms(spec.text("file"), size));
  makeSequence(shots);
  return shots;
}

}  // namespace latelight::data
