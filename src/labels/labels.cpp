#include "labels/labels.h"

#include <algorithm>
#include <unordered_map>

#include "labels/amodal.h"
#include "render/submit/describe.h"
#include "render/submit/id_manifest.h"

namespace latelight::labels {

namespace {

// Views that are rendered at once. Their objects share images (amodal.h), which is possible the less, the more views
// there are.
constexpr size_t kViewsAtOnce = 256;

std::vector<Object> objectsIn(const scene::Camera& camera, const scene::Scene& scene, const render::Settings& settings,
                              const render::SceneState& moment) {
  const bool zUp = settings.axes == render::Axes::ZUp;
  const scene::Pose& pose = moment.poses.current;
  if (moment.worlds.count == 0) return objectsOf(scene, pose, zUp);
  return objectsOf(scene, pose, zUp, placedInstances(scene, pose, moment.worlds, camera.world),
                   deformedVertices(scene, pose, moment.worlds, camera.world));
}

// Fills everything except the camera. `objects`: with their amodal masks.
void addObjects(PictureLabels& labels, std::vector<Object>&& objects,
                const std::unordered_map<uint32_t, std::string>& nodes) {
  std::map<uint32_t, Mask> visible = masksOf(labels.ids);
  const uint32_t width = labels.ids.width, height = labels.ids.height;
  for (Object& object : objects) {
    if (object.alone.area() == 0) continue;
    Mask& seen = visible[object.id];
    if (seen.runs.empty()) seen = {width, height, {width * height}};
    labels.objects.push_back({std::move(object), nodes.at(object.id), std::move(seen)});
  }
}

}  // namespace

std::vector<PictureLabels> labelObjects(render::Renderer& renderer, const scene::Scene& scene,
                                        std::span<const scene::Camera> cameras, const render::Settings& settings,
                                        const render::SceneState& moment) {
  render::Settings ids = settings;
  ids.display = false;
  ids.aovs = {output::Aov::Id};
  std::unordered_map<uint32_t, std::string> nodes;
  for (output::IdEntry& entry : render::idManifest(scene).ids) nodes.emplace(entry.id, std::move(entry.node));
  std::vector<PictureLabels> all;
  for (size_t first = 0; first < cameras.size(); first += kViewsAtOnce) {
    const auto some = cameras.subspan(first, std::min(kViewsAtOnce, cameras.size() - first));
    std::vector<output::FrameOutput> frames = renderer.render(some, ids, moment);
    std::vector<std::vector<Object>> objects;
    for (const scene::Camera& camera : some) objects.push_back(objectsIn(camera, scene, settings, moment));
    renderIsolated(renderer, scene, {some.begin(), some.end()}, settings, moment, objects, true);
    for (size_t i = 0; i < some.size(); ++i) {
      all.push_back(
          {.ids = std::move(frames[i].aovs.front()), .camera = render::describeCamera(some[i], scene, settings)});
      addObjects(all.back(), std::move(objects[i]), nodes);
    }
  }
  return all;
}

}  // namespace latelight::labels
