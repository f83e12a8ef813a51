// Functions of modules that need Vulkan, to which the sources of targets refer. Targets use the names of three lighting
// techniques and call none of the other functions.
#include "app/render_pick.h"
#include "fuzz/fuzz.h"
#include "render/lighting/technique.h"
#include "render/submit/picking.h"
#include "render/submit/session.h"

namespace latelight {

std::span<const render::TechniqueInfo> render::allTechniques() {
  static const std::vector<TechniqueInfo> all = {{.name = "clustered", .description = "in clusters"},
                                                 {.name = "forward", .description = "forward", .forward = true},
                                                 {.name = "reference", .description = "paths", .traces = true}};
  return all;
}
std::span<const render::TechniqueInfo> render::techniques() {
  return allTechniques().first(2);
}
std::string render::techniquesThatCompute() {
  return "clustered";
}

void render::checkPixels(const Settings&, std::span<const glm::uvec2>) {
  fuzz::report("pixels are checked");
}
std::vector<glm::uvec2> app::parsePixels(const std::vector<std::string>&) {
  fuzz::report("pixels are read");
}
glm::dmat4 render::openCvPose(const scene::Camera&, const scene::Scene&, bool) {
  fuzz::report("a camera of a scene is read");
}
glm::dmat4 render::toWorldFromOpenCv(const glm::dmat4&, const scene::Scene&) {
  fuzz::report("a camera of a scene is placed");
}

}  // namespace latelight
