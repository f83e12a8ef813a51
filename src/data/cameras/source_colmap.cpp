#include "data/cameras/colmap.h"

namespace latelight::data {

std::vector<Shot> shotsOfColmap(Spec& spec, const CameraContext& context) {
  return placeCameras(spec, context, readColmap(spec.text("folder")));
}

}  // namespace latelight::data
