#include "data/extras.h"

#include <algorithm>

#include "data/amodal.h"

namespace latelight::data {

Extras both(const Extras& a, const Extras& b) {
  return {a.boxes || b.boxes, a.alone || b.alone, a.shapes || b.shapes, std::max(a.samples, b.samples)};
}

void renderExtras(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                  const render::Settings& settings, const render::SceneState& moment, const Extras& needed,
                  GeometryHashes& geometry, DataFrame& frame) {
  if (needed.boxes || needed.alone || needed.shapes)
    frame.objects =
        objectsOf(scene, moment.poses.current, settings.axes == render::Axes::ZUp, needed.shapes ? &geometry : nullptr);
  if (needed.alone) renderIsolated(renderer, scene, camera, settings, moment, frame.objects);
  if (needed.samples == 0) return;
  render::Settings fine = settings;
  fine.width *= needed.samples;
  fine.height *= needed.samples;
  fine.display = false;
  fine.aovs = {output::Aov::Id, output::Aov::Material};
  render::SceneState poses{moment.poses, {}, {}, {}, false};
  frame.samples = std::move(renderer.render({&camera, 1}, fine, poses).front());
}

}  // namespace latelight::data
