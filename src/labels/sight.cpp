#include "labels/sight.h"

#include <algorithm>
#include <cmath>

#include "render/frame/view.h"
#include "render/submit/session.h"
#include "scene/file_frame.h"

namespace latelight::labels {

namespace {

// The width of the image of one pixel around a line, as an angle, or in meters for orthographic cameras. Rasterization
// rounds vertices to 1/256 of it.
constexpr float kPixelAngle = 1e-3f, kPixelMeters = 1e-3f;
constexpr size_t kMaxLines = 4096;  // at once

// `pose`: of the camera.
SightSegment segmentTo(const glm::dvec3& point, const glm::dmat4& pose, const scene::Camera& camera) {
  const glm::dvec3 eye(pose[3]), axis(pose[2]);
  const double depth = glm::dot(point - eye, axis);
  const glm::dvec3 origin = camera.orthographic ? point - depth * axis : eye;
  SightSegment segment{origin, point - origin};
  if (render::bendsRays(camera)) return segment;
  const double near = camera.nearClip;
  segment.clipped = !(depth >= near && depth <= camera.farClip);
  if (segment.clipped || depth == near) return segment;
  const glm::dvec3 toNear = camera.orthographic ? near * axis : near / depth * segment.direction;
  const double start = camera.orthographic ? near : near / depth * glm::length(segment.direction);
  return {origin + toNear, segment.direction - toNear, start};
}

Sight sightAt(const SightSegment& segment, double hit, uint32_t id, double slack) {
  Sight sight{segment.distance(), std::numeric_limits<double>::infinity(), 0, segment.clipped};
  if (segment.isFreeUpTo(hit, slack)) return sight;
  sight.hit = segment.start + hit;
  sight.id = id;
  return sight;
}

// A camera that looks along the segment, which begins at its near plane.
scene::Camera aimed(const scene::Camera& like, const SightSegment& segment, const scene::Scene& scene, bool zUp) {
  const double length = glm::length(segment.direction);
  const glm::dvec3 forward = length > 0 ? segment.direction / length : glm::dvec3(0, 0, 1);
  const glm::dvec3 side = std::abs(forward.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 down = glm::normalize(glm::cross(forward, side));
  const glm::dmat4 pose(glm::dvec4(glm::cross(down, forward), 0), glm::dvec4(down, 0), glm::dvec4(forward, 0),
                        glm::dvec4(segment.origin - segment.start * forward, 1));
  scene::Camera camera;
  camera.toWorld = render::toWorldFromOpenCv(zUp ? scene::fileFromWorld(scene) * pose : pose, scene);
  camera.orthographic = like.orthographic;
  camera.verticalFov = kPixelAngle;
  camera.yHalf = kPixelMeters / 2;
  camera.world = like.world;
  const auto near = static_cast<float>(segment.start);
  if (like.orthographic) {
    camera.nearClip = near;
    camera.farClip = static_cast<float>(segment.start + (length > 0 ? 2 * length : 1));
  } else {
    camera.nearClip = std::max(camera.nearClip, near);
  }
  return camera;
}

}  // namespace

SightSegment sightSegment(const glm::dvec3& point, const scene::Camera& camera, const scene::Scene& scene, bool zUp) {
  return segmentTo(point, render::openCvPose(camera, scene, zUp), camera);
}

std::vector<Sight> sightsOf(render::Renderer& renderer, std::span<const SightSegment> segments,
                            const render::Settings& settings, const render::SceneState& moment, double slack) {
  std::vector<glm::dvec3> origins, directions;
  for (const SightSegment& segment : segments) {
    origins.push_back(segment.origin);
    directions.push_back(segment.direction);
  }
  render::Settings cast = settings;
  cast.normalFrame = render::NormalFrame::World;  // the only frame that rays accept; no normals are cast
  const render::CastHits hits = renderer.cast({.origins = origins, .directions = directions}, cast, moment).hits;
  std::vector<Sight> sights;
  for (size_t i = 0; i < segments.size(); ++i)
    sights.push_back(sightAt(segments[i], hits.distance[i], hits.id[i], slack));
  return sights;
}

std::vector<Sight> sightsOf(render::Renderer& renderer, const scene::Scene& scene, const scene::Camera& camera,
                            const render::Settings& settings, const render::SceneState& moment,
                            std::span<const glm::dvec3> points, double slack) {
  const glm::dmat4 pose = render::openCvPose(camera, scene, settings.axes == render::Axes::ZUp);
  std::vector<SightSegment> segments;
  for (const glm::dvec3& point : points) segments.push_back(segmentTo(point, pose, camera));
  return sightsOf(renderer, segments, settings, moment, slack);
}

std::vector<Sight> sightsOfWorlds(render::Renderer& renderer, const scene::Scene& scene,
                                  std::span<const SightLine> lines, const render::Settings& settings,
                                  const render::SceneState& moment, double slack) {
  const bool zUp = settings.axes == render::Axes::ZUp;
  render::Settings onePixel = settings;
  onePixel.width = onePixel.height = 1;
  onePixel.display = false;
  onePixel.aovs = {output::Aov::Id, output::Aov::Distance};
  std::vector<Sight> sights;
  for (size_t first = 0; first < lines.size(); first += kMaxLines) {
    const auto some = lines.subspan(first, std::min(kMaxLines, lines.size() - first));
    std::vector<SightSegment> segments;
    std::vector<scene::Camera> cameras;
    for (const SightLine& line : some) {
      const glm::dmat4 pose = render::openCvPose(*line.camera, scene, zUp);
      segments.push_back(segmentTo(line.point, pose, *line.camera));
      cameras.push_back(aimed(*line.camera, segments.back(), scene, zUp));
    }
    const std::vector<output::FrameOutput> frames = renderer.render(cameras, onePixel, moment);
    for (size_t i = 0; i < some.size(); ++i) {
      const uint32_t id = frames[i].aovs[0].ids[0];
      const double hit =
          id != 0 ? frames[i].aovs[1].values[0] - segments[i].start : std::numeric_limits<double>::infinity();
      sights.push_back(sightAt(segments[i], hit, id, slack));
    }
  }
  return sights;
}

}  // namespace latelight::labels
