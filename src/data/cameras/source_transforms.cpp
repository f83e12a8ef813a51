#include "data/cameras/transforms.h"

namespace latelight::data {

std::vector<Shot> shotsOfTransforms(Spec& spec, const CameraContext& context) {
  return placeCameras(spec, context, readTransforms(spec.text("file"), readSize(spec)));
}

}  // namespace latelight::data
