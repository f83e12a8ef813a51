#include "data/cameras/tum.h"

namespace latelight::data {

std::vector<Shot> shotsOfTum(Spec& spec, const CameraContext& context) {
  return placeCameras(spec, context, readTum(spec.text("file")));
}

}  // namespace latelight::data
