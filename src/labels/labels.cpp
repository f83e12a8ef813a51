#include "labels/labels.h"

#include <algorithm>
#include <unordered_map>

#include "labels/amodal.h"
#include "render/submit/describe.h"
#include "render/submit/id_manifest.h"

namespace latelight::labels {

PictureLabels labelObjects(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                           const render::Settings& settings, const render::SceneState& moment) {
  render::Settings ids = settings;
  ids.display = false;
  ids.aovs = {output::Aov::Id};
  PictureLabels labels{.ids = {}, .camera = render::describeCamera(camera, scene, settings), .objects = {}};
  labels.ids = std::move(renderer.render({&camera, 1}, ids, moment).front().aovs.front());
  std::vector<Object> objects = objectsOf(scene, moment.poses.current, settings.axes == render::Axes::ZUp);
  renderIsolated(renderer, scene, camera, settings, moment, objects, true);
  std::map<uint32_t, Mask> visible = masksOf(labels.ids);
  std::unordered_map<uint32_t, std::string> nodes;
  for (output::IdEntry& entry : render::idManifest(scene).ids) nodes.emplace(entry.id, std::move(entry.node));
  for (Object& object : objects) {
    if (object.alone.area() == 0) continue;
    Mask& seen = visible[object.id];
    if (seen.runs.empty()) seen = {settings.width, settings.height, {settings.width * settings.height}};
    labels.objects.push_back({std::move(object), nodes[object.id], std::move(seen)});
  }
  return labels;
}

}  // namespace latelight::labels
