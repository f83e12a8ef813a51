#include "study/study.h"

#include "render/base/registry.h"

namespace latelight::study {

std::span<const Study> studies() {
  static const Study all[] = {
      {"normals",
       "error of every normal encoding and bit budget over the sphere, degrees",
       studyNormals,
       {"samples", "seed", "bits"}},
      {"depth", "relative error of view depth through depth formats and packings", studyDepth, {"samples"}},
      {"position", "error of the three reconstructions of position from depth, meters", studyPosition, {"samples"}},
      {"lights",
       "cost and scaling of every lighting technique by lights, triangles and pixels",
       studyLights,
       {"lights", "triangles", "sizes", "budget"}},
      {"accuracy",
       "error of finished images relative to the integral of light, 8-bit levels",
       studyAccuracy,
       {"samples", "hdri"}},
  };
  return all;
}

const Study& findStudy(std::string_view name) {
  return render::findByName(studies(), name, "study");
}

}  // namespace latelight::study
