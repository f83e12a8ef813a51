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

// Share of the distance within which a surface counts as the point itself. A point is off its surface by rounding,
// which a line of sight along the surface multiplies.
constexpr double kPixelSlack = 1e-4;

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

Correspondence correspond(render::Renderer& renderer, const scene::Scene& scene, const Shot& first, const Shot& second,
                          const render::Settings& common) {
  const render::Settings settings = settingsOf(first, common), others = settingsOf(second, common);
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const glm::dvec3 eye(render::openCvPose(first.camera, scene, settings.axes == render::Axes::ZUp)[3]);
  const output::FrameOutput frame = renderFirst(renderer, first, second, settings, eye);
  const std::vector<uint32_t>& ids = imageOf(frame, Aov::Id).ids;
  const output::CameraMetadata described = render::describeCamera(second.camera, scene, others);
  const Projector projector(described);
  const glm::dmat4 cameraFromFrame = glm::inverse(described.cameraToWorld);
  Correspondence result{settings.width,
                        settings.height,
                        std::vector(ids.size(), glm::vec2(kNone)),
                        std::vector(ids.size(), kNone),
                        std::vector<uint8_t>(ids.size()),
                        std::vector(ids.size(), glm::vec3(0))};
  std::vector<glm::dvec3> moved(ids.size());
  parallelFor(ids.size(), size_t{1} << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (ids[i] == 0) continue;
      result.flow[i] = vectorAt(imageOf(frame, Aov::SceneFlow), i);
      moved[i] = eye + glm::dvec3(vectorAt(imageOf(frame, Aov::Position), i)) + glm::dvec3(result.flow[i]);
      const auto at = projector.project(glm::dvec3(cameraFromFrame * glm::dvec4(moved[i], 1)));
      if (!at) continue;
      result.pixels[i] = glm::vec2(*at);
      result.depth[i] = static_cast<float>(at->z);
    }
  });
  std::vector<size_t> inside;  // pixels whose points lie within the second image
  std::vector<glm::dvec3> points;
  for (size_t i = 0; i < ids.size(); ++i) {
    const glm::vec2 p = result.pixels[i];
    if (!(p.x >= 0 && p.y >= 0 && p.x < float(others.width) && p.y < float(others.height))) continue;
    inside.push_back(i);
    points.push_back(moved[i]);
  }
  if (inside.empty()) return result;
  render::SceneState then;
  then.poses = {second.pose, second.pose, second.pose};
  const std::vector<Sight> sights = sightsOf(renderer, scene, second.camera, settings, then, points, kPixelSlack);
  for (size_t i = 0; i < inside.size(); ++i) result.visible[inside[i]] = std::isinf(sights[i].hit) ? 1 : 0;
  return result;
}

}  // namespace latelight::labels
