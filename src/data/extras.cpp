#include "data/extras.h"

#include <algorithm>
#include <cassert>

#include "labels/amodal.h"
#include "render/submit/session.h"

namespace latelight::data {

Extras both(const Extras& a, const Extras& b) {
  assert(a.keypoints.empty() || b.keypoints.empty() || a.keypoints == b.keypoints);
  std::vector<PairTarget> pairs = a.pairs;
  for (const PairTarget& target : b.pairs)
    if (std::ranges::find(pairs, target) == pairs.end()) pairs.push_back(target);
  ScanRequests scans = a.scans;
  for (const auto& scan : b.scans)
    if (std::ranges::none_of(scans, [&](const auto& other) { return other->key == scan->key; })) scans.push_back(scan);
  return {.boxes = a.boxes || b.boxes,
          .alone = a.alone || b.alone,
          .order = a.order || b.order,
          .shapes = a.shapes || b.shapes,
          .keypoints = a.keypoints.empty() ? b.keypoints : a.keypoints,
          .pairs = std::move(pairs),
          .scans = std::move(scans),
          .samples = std::max(a.samples, b.samples)};
}

void renderExtras(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                  const render::Settings& settings, const render::SceneState& moment, const Extras& needed,
                  GeometryHashes& geometry, DataFrame& frame) {
  if (needed.boxes || needed.alone || needed.order || needed.shapes)
    frame.objects = labels::objectsOf(scene, moment.poses.current, settings.axes == render::Axes::ZUp,
                                      needed.shapes ? &geometry : nullptr);
  if (needed.alone || needed.order)
    labels::renderIsolated(renderer, scene, camera, settings, moment, frame.objects, needed.order);
  if (!needed.keypoints.empty())
    frame.keypoints =
        keypointsOfObjects(renderer, scene, camera, settings, moment, *frame.metadata.ids, needed.keypoints);
  if (needed.samples == 0) return;
  render::Settings fine = settings;
  fine.width *= needed.samples;
  fine.height *= needed.samples;
  fine.display = false;
  fine.aovs = {output::Aov::Id, output::Aov::Material};
  frame.samples = std::move(renderer.render({&camera, 1}, fine, render::onlyReadout(moment, fine)).front());
}

}  // namespace latelight::data
