#include "base/error.h"
#include "data/cameras/bop.h"

namespace latelight::data {

std::vector<Shot> shotsOfBop(Spec& spec, const CameraContext& context) {
  const PictureSize size = readSize(spec);
  if (size.width == 0) badUsage("{} needs \"size\": scene_camera.json does not say of how many pixels", spec.path());
  return placeCameras(spec, context, readBop(spec.text("file"), size));
}

}  // namespace latelight::data
