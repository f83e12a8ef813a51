#include "app/render_metadata.h"

#include <fmt/core.h>
#include <latelight/latelight.h>

#include "render/submit/describe.h"

namespace latelight::app {

output::Metadata describeRender(const scene::Scene& scene, const scene::Camera& camera, const vk::Device& device,
                                const std::string& environment, const RenderOptions& o) {
  output::Metadata m = render::describe(scene, camera, environment, o.settings, o.given);
  m.frame = o.frame;
  m.device = {device.info().name, device.info().driver, device.info().uuid};
  m.versions = {{"latelight", version()}, {"vulkan", device.info().apiVersion}};
  if (o.idDepth) m.settings["id-depth"] = fmt::format("{}", *o.idDepth);
  if (!o.idNodes.empty()) m.settings["id-nodes"] = o.idNodes;
  if (!o.unit.empty()) m.settings["unit"] = o.unit;
  if (!o.upAxis.empty()) m.settings["up-axis"] = o.upAxis;
  if (o.pointRadius) m.settings["point-radius"] = fmt::format("{}", *o.pointRadius);
  if (o.turn != 0) m.settings["turn"] = fmt::format("{}", o.turn);
  if (!o.settings.time && o.turn == 0) m.settings.erase("fps");
  return m;
}

}  // namespace latelight::app
