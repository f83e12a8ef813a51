#include "labels/correspondence.h"

#include <cmath>

#include "base/parallel.h"
#include "labels/projector.h"
#include "labels/sight.h"
#include "render/submit/describe.h"
#include "render/submit/session.h"
#include "scene/file_frame.h"

namespace latelight::labels {

namespace {

using output::Aov;

const output::AovImage& imageOf(const output::FrameOutput& frame, Aov aov) {
  return *std::ranges::find(frame.aovs, aov, &output::AovImage::aov);
}

glm::vec3 vectorAt(const output::AovImage& image, size_t pixel) {
  return {image.values[3 * pixel], image.values[3 * pixel + 1], image.values[3 * pixel + 2]};
}

render::Settings settingsOf(const Shot& shot, render::Settings settings) {
  if (shot.width != 0) settings.width = shot.width;
  if (shot.height != 0) settings.height = shot.height;
  return settings;
}

// Renders the first image. Positions are relative to its eye, so that floats hold them precisely.
output::FrameOutput renderFirst(render::Renderer& renderer, const Shot& first, const Shot& second,
                                render::Settings settings, const glm::dvec3& eye) {
  settings.display = false;
  settings.aovs = {Aov::Id, Aov::Position, Aov::SceneFlow};
  settings.shutter = settings.readout = 0;
  settings.positionOrigin = {eye};
  render::SceneState moment;
  moment.poses = {first.pose, first.pose, second.pose};
  return std::move(renderer.render({&first.camera, 1}, settings, moment).front());
}

}  // namespace

LocatedPixels locate(const output::FrameOutput& first, const glm::dvec3& origin, const scene::Camera& second,
                     const scene::Scene& scene, const render::Settings& others) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const output::AovImage& image = imageOf(first, Aov::Id);
  const std::vector<uint32_t>& ids = image.ids;
  const output::CameraMetadata described = render::describeCamera(second, scene, others);
  const Projector projector(described);
  const glm::dmat4 cameraFromFrame = glm::inverse(described.cameraToWorld);
  LocatedPixels located{
      .result = {image.width, image.height, std::vector(ids.size(), glm::vec2(kNone)), std::vector(ids.size(), kNone),
                 std::vector<uint8_t>(ids.size()), std::vector(ids.size(), glm::vec3(0))},
      .inside = {},
      .points = {}};
  Correspondence& result = located.result;
  std::vector<glm::dvec3> moved(ids.size());
  parallelFor(ids.size(), size_t{1} << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (ids[i] == 0) continue;
      result.flow[i] = vectorAt(imageOf(first, Aov::SceneFlow), i);
      moved[i] = origin + glm::dvec3(vectorAt(imageOf(first, Aov::Position), i)) + glm::dvec3(result.flow[i]);
      const auto at = projector.project(glm::dvec3(cameraFromFrame * glm::dvec4(moved[i], 1)));
      if (!at) continue;
      result.pixels[i] = glm::vec2(*at);
      result.depth[i] = static_cast<float>(at->z);
    }
  });
  for (size_t i = 0; i < ids.size(); ++i) {
    const glm::vec2 p = result.pixels[i];
    if (!(p.x >= 0 && p.y >= 0 && p.x < float(others.width) && p.y < float(others.height))) continue;
    located.inside.push_back(i);
    located.points.push_back(moved[i]);
  }
  return located;
}

Correspondence correspond(render::Renderer& renderer, const scene::Scene& scene, const Shot& first, const Shot& second,
                          const render::Settings& common) {
  const render::Settings settings = settingsOf(first, common), others = settingsOf(second, common);
  const glm::dvec3 eye(render::openCvPose(first.camera, scene, settings.axes == render::Axes::ZUp)[3]);
  const output::FrameOutput frame = renderFirst(renderer, first, second, settings, eye);
  LocatedPixels located = locate(frame, eye, second.camera, scene, others);
  if (located.inside.empty()) return std::move(located.result);
  render::SceneState then;
  then.poses = {second.pose, second.pose, second.pose};
  const std::vector<Sight> sights =
      sightsOf(renderer, scene, second.camera, settings, then, located.points, kPixelSlack);
  for (size_t i = 0; i < located.inside.size(); ++i)
    located.result.visible[located.inside[i]] = std::isinf(sights[i].hit) && !sights[i].clipped ? 1 : 0;
  return std::move(located.result);
}

}  // namespace latelight::labels
