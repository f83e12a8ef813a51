#include "data/formats/camera_support.h"

#include "base/error.h"

namespace latelight::data {

void requirePerspective(std::string_view format, const output::CameraMetadata& camera) {
  if (camera.orthographic)
    badUsage("the format {} cannot express orthographic cameras such as \"{}\": choose other cameras or another format",
             format, camera.name);
}

void requirePinhole(std::string_view format, const output::CameraMetadata& camera) {
  requirePerspective(format, camera);
  if (camera.lens)
    badUsage(
        "the format {} cannot express cameras with a lens such as that of \"{}\": choose other cameras or another "
        "format",
        format, camera.name);
}

}  // namespace latelight::data
