// The labels of the public API: objects, keypoints and correspondence.
#include "labels/labels.h"

#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "api/renderer.h"
#include "api/settings.h"
#include "api/transform.h"
#include "base/error.h"
#include "base/memory.h"
#include "labels/correspondence.h"
#include "labels/keypoints.h"
#include "labels/projector.h"
#include "labels/sight.h"
#include "render/exposure/check.h"
#include "render/options/options.h"
#include "render/submit/session.h"
#include "scene/animation.h"

namespace latelight {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::array<double, 3> threeOf(glm::dvec3 v) {
  return {v.x, v.y, v.z};
}

PixelBox boxOf(const labels::PixelBox& box) {
  return {box.x, box.y, box.width, box.height};
}

std::vector<uint8_t> flagsOf(const labels::Mask& mask) {
  std::vector<uint8_t> pixels = mask.pixels();
  for (uint8_t& pixel : pixels) pixel = pixel != 0;
  return pixels;
}

ObjectLabel publicLabel(const labels::LabeledObject& from, const output::CameraMetadata& camera) {
  const labels::Object& object = from.object;
  ObjectLabel label{.id = object.id, .node = from.node};
  label.visiblePixels = from.visible.area();
  label.amodalPixels = object.alone.area();
  label.fullPixels = object.pixels;
  label.visibleShare = static_cast<double>(label.visiblePixels) / static_cast<double>(label.fullPixels);
  label.visibleBox = boxOf(from.visible.box());
  label.amodalBox = boxOf(object.alone.box());
  label.fullBox = boxOf(object.full);
  const glm::dmat4 toCamera = glm::inverse(camera.cameraToWorld) * object.toWorld;
  label.objectToWorld = rowsOf(object.toWorld);
  label.objectToCamera = rowsOf(toCamera);
  label.boxMin = threeOf(object.low);
  label.boxMax = threeOf(object.high);
  const labels::Projector projector(camera);
  const std::array<glm::dvec3, 8> corners = cornersOf(object);
  for (size_t i = 0; i < corners.size(); ++i)
    label.corners[i] =
        threeOf(projector.project(glm::dvec3(toCamera * glm::dvec4(corners[i], 1))).value_or(glm::dvec3(kNone)));
  label.visibleMask = flagsOf(from.visible);
  label.amodalMask = flagsOf(object.alone);
  return label;
}

Correspondence publicCorrespondence(labels::Correspondence&& from) {
  Correspondence result{.width = from.width, .height = from.height};
  for (const glm::vec2 p : from.pixels) result.pixels.push_back({p.x, p.y});
  for (const glm::vec3 f : from.flow) result.flow.push_back({f.x, f.y, f.z});
  result.depth = std::move(from.depth);
  result.visible = std::move(from.visible);
  return result;
}

// Returns the scene's pose for the second image of a correspondence.
scene::Pose poseAtTime(const scene::Scene& scene, render::Settings settings, std::optional<double> time) {
  if (time) settings.time = *time;
  render::checkSettings(settings);
  return render::posesAt(scene, settings).current;
}

}  // namespace

namespace {

Labels publicLabels(labels::PictureLabels&& from) {
  Labels result{.width = from.ids.width, .height = from.ids.height, .ids = std::move(from.ids.ids)};
  const size_t count = from.objects.size();
  result.occlusions.assign(count * count, 0);
  for (size_t i = 0; i < count; ++i) {
    result.objects.push_back(publicLabel(from.objects[i], from.camera));
    for (const labels::Occlusion& other : from.objects[i].object.occludes) {
      const auto behind = std::ranges::lower_bound(from.objects, other.id, {},
                                                   [](const labels::LabeledObject& o) { return o.object.id; });
      result.occlusions[i * count + static_cast<size_t>(behind - from.objects.begin())] = other.pixels;
    }
  }
  return result;
}

std::vector<labels::Keypoint> internalKeypoints(const std::vector<Keypoint>& keypoints) {
  std::vector<labels::Keypoint> points;
  for (const Keypoint& k : keypoints) {
    if (!std::isfinite(k.position[0] + k.position[1] + k.position[2]) || !(k.thickness >= 0))
      badUsage("the keypoint \"{}\" must have a finite position and a thickness of at least 0", k.name);
    points.push_back({k.name, k.node, {k.position[0], k.position[1], k.position[2]}, k.thickness});
  }
  return points;
}

std::vector<KeypointLabel> publicKeypoints(const std::vector<labels::ProjectedKeypoint>& projected) {
  std::vector<KeypointLabel> result;
  for (const labels::ProjectedKeypoint& p : projected)
    result.push_back({threeOf(p.position), {p.pixel.x, p.pixel.y}, p.depth, static_cast<uint32_t>(p.visibility)});
  return result;
}

}  // namespace

Renderer::Impl::LabelInput Renderer::Impl::labelInput(const Camera& camera, const Options& options) const {
  owner.require("the renderer");
  const render::Settings settings = withExposure(settingsFor(*device, options, scene), camera);
  return {.camera = render::fitted(internalCamera(camera, scene), settings.cameraFit),
          .settings = settings,
          .moment = internalState(options, settings, scene, 1)};
}

Renderer::Impl::WorldLabelInput Renderer::Impl::worldLabelInput(const Worlds& worlds, const Options& options) {
  owner.require("the renderer");
  WorldLabelInput input{
      .cameras = {}, .settings = settingsFor(*device, options, scene, rasterUseOf(worlds)), .moment = {}};
  render::checkExposure(input.settings, {.worlds = true});
  rejectExposures(worlds.cameras);
  input.moment = internalState(options, input.settings, scene, 0);
  if (worlds.arrays.ready > 0 && inputTimeline) device->waitFirst(inputTimeline->get(), worlds.arrays.ready);
  input.cameras = source.convert(worlds, input.settings, input.moment, renderer, *device, true).cameras;
  input.moment.previousCameras.clear();
  input.moment.nextCameras.clear();
  return input;
}

Labels Renderer::labels(const Camera& camera, const Options& options) try {
  const Impl::LabelInput input = filled().labelInput(camera, options);
  return publicLabels(std::move(
      labels::labelObjects(impl_->renderer, impl_->scene, {&input.camera, 1}, input.settings, input.moment).front()));
} catch (const std::bad_alloc&) {
  failWithoutMemory("the labels");
}

std::vector<KeypointLabel> Renderer::keypoints(const Camera& camera, const std::vector<Keypoint>& keypoints,
                                               const Options& options) try {
  const Impl::LabelInput input = filled().labelInput(camera, options);
  return publicKeypoints(labels::projectKeypoints(impl_->renderer, impl_->scene, input.camera, input.settings,
                                                  input.moment, internalKeypoints(keypoints)));
} catch (const std::bad_alloc&) {
  failWithoutMemory("the labels");
}

std::vector<Labels> Renderer::labels(const Worlds& worlds, const Options& options) try {
  const Impl::WorldLabelInput input = filled().worldLabelInput(worlds, options);
  std::vector<Labels> all;
  for (labels::PictureLabels& each :
       labels::labelObjects(impl_->renderer, impl_->scene, input.cameras, input.settings, input.moment))
    all.push_back(publicLabels(std::move(each)));
  return all;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the labels");
}

std::vector<std::vector<KeypointLabel>> Renderer::keypoints(const Worlds& worlds,
                                                            const std::vector<Keypoint>& keypoints,
                                                            const Options& options) try {
  const Impl::WorldLabelInput input = filled().worldLabelInput(worlds, options);
  std::vector<std::vector<KeypointLabel>> all;
  for (const auto& each : labels::projectKeypointsOfWorlds(impl_->renderer, impl_->scene, input.cameras, input.settings,
                                                           input.moment, internalKeypoints(keypoints)))
    all.push_back(publicKeypoints(each));
  return all;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the labels");
}

Correspondence Renderer::correspond(const Camera& first, const Camera& second, const Options& options,
                                    std::optional<double> secondTime) try {
  const Impl::LabelInput input = filled().labelInput(first, options);
  if (secondTime && !input.settings.time)
    badUsage("the second image has a time, so the first needs one as well: set Options::time");
  if (secondTime && !std::isfinite(*secondTime)) badUsage("the time must be a number of seconds");
  const scene::Camera other = filled().labelInput(second, options).camera;
  const scene::Pose then = poseAtTime(impl_->scene, input.settings, secondTime);
  labels::Correspondence found = labels::correspond(
      impl_->renderer, impl_->scene, {input.camera, input.moment.poses.current}, {other, then}, input.settings);
  return publicCorrespondence(std::move(found));
} catch (const std::bad_alloc&) {
  failWithoutMemory("the labels");
}

namespace {

// The values of the next frame in place of the current ones.
Worlds nextFrameOf(const Worlds& worlds) {
  Worlds next = worlds;
  WorldArrays& a = next.arrays;
  if (!next.nextTransforms.empty()) next.transforms = next.nextTransforms;
  if (!next.nextCameraToWorld.empty()) next.cameraToWorld = next.nextCameraToWorld;
  for (auto* list :
       {&next.previousTransforms, &next.nextTransforms, &next.previousCameraToWorld, &next.nextCameraToWorld})
    list->clear();
  using Times = std::array<WorldArray*, 3>;
  for (const auto& [current, previous, then] :
       {Times{&a.transforms, &a.previousTransforms, &a.nextTransforms},
        {&a.cameraToWorld, &a.previousCameraToWorld, &a.nextCameraToWorld},
        {&a.jointTransforms, &a.previousJointTransforms, &a.nextJointTransforms},
        {&a.vertices, &a.previousVertices, &a.nextVertices}}) {
    if (*then) *current = *then;
    *previous = *then = {};
  }
  return next;
}

// The first eye that is somewhere: floats hold positions near it precisely, however far from the origin worlds are.
glm::dvec3 firstEye(std::span<const scene::Camera> cameras, const scene::Scene& scene, bool zUp) {
  for (const scene::Camera& camera : cameras) {
    const glm::dvec3 eye(render::openCvPose(camera, scene, zUp)[3]);
    if (std::isfinite(eye.x + eye.y + eye.z)) return eye;
  }
  return glm::dvec3(0);
}

// The lines of sight to the located points of all views, as many per world: others are filled up.
struct WorldSights {
  uint64_t count = 0;  // per world
  std::vector<double> origins, directions;
  std::vector<labels::SightSegment> segments;  // per line
};

WorldSights sightsTo(std::span<const labels::LocatedPixels> views, std::span<const scene::Camera> cameras,
                     const scene::Scene& scene, bool zUp, size_t worlds) {
  const size_t each = views.size() / worlds;
  WorldSights sights;
  std::vector<uint64_t> counts(worlds);
  for (size_t view = 0; view < views.size(); ++view) counts[view / each] += views[view].points.size();
  sights.count = *std::ranges::max_element(counts);
  for (size_t world = 0; world < worlds; ++world) {
    for (size_t view = world * each; view < (world + 1) * each; ++view)
      for (const glm::dvec3& point : views[view].points) {
        const labels::SightSegment segment = labels::sightSegment(point, cameras[view], scene, zUp);
        for (int i = 0; i < 3; ++i) sights.origins.push_back(segment.origin[i]);
        for (int i = 0; i < 3; ++i) sights.directions.push_back(segment.direction[i]);
        sights.segments.push_back(segment);
      }
    sights.origins.resize((world + 1) * sights.count * 3, 0);
    sights.directions.resize((world + 1) * sights.count * 3, 1);
    sights.segments.resize((world + 1) * sights.count);
  }
  return sights;
}

}  // namespace

std::vector<Correspondence> Renderer::correspond(const Worlds& worlds, const Options& options) try {
  Impl::WorldLabelInput input = filled().worldLabelInput(worlds, options);
  const Worlds next = nextFrameOf(worlds);
  const std::vector<scene::Camera> seconds = filled().worldLabelInput(next, options).cameras;
  input.settings.display = false;
  input.settings.aovs = {output::Aov::Id, output::Aov::Position, output::Aov::SceneFlow};
  const bool zUp = input.settings.axes == render::Axes::ZUp;
  const glm::dvec3 origin = firstEye(input.cameras, impl_->scene, zUp);
  input.settings.positionOrigin = {origin};
  std::vector<labels::LocatedPixels> views;
  const std::vector<output::FrameOutput> frames = impl_->renderer.render(input.cameras, input.settings, input.moment);
  for (size_t i = 0; i < frames.size(); ++i)
    views.push_back(labels::locate(frames[i], origin, seconds[i], impl_->scene, input.settings));
  const WorldSights sights = sightsTo(views, seconds, impl_->scene, zUp, worlds.count);
  std::vector<float> distances(worlds.count * sights.count);
  if (!distances.empty()) {
    WorldRays rays{.origins = {.element = WorldArray::Element::Float64, .host = sights.origins.data()},
                   .directions = {.element = WorldArray::Element::Float64, .host = sights.directions.data()},
                   .count = sights.count};
    Options castOptions = options;
    castOptions.normalFrame = "world";  // the only frame that rays accept; no normals are cast
    cast(next, rays, {"distance"}, castOptions).at("distance").copyToHost(std::as_writable_bytes(std::span(distances)));
  }
  std::vector<Correspondence> all;
  const size_t each = views.size() / worlds.count;
  for (size_t view = 0, ray = 0; view < views.size(); ++view) {
    if (view % each == 0) ray = view / each * sights.count;
    labels::LocatedPixels& located = views[view];
    for (const size_t pixel : located.inside) {
      const labels::SightSegment& sight = sights.segments[ray];
      const bool isFree = sight.isFreeUpTo(distances[ray++], labels::kPixelSlack);
      located.result.visible[pixel] = isFree && !sight.clipped ? 1 : 0;
    }
    all.push_back(publicCorrespondence(std::move(located.result)));
  }
  return all;
} catch (const std::bad_alloc&) {
  failWithoutMemory("the labels");
}

}  // namespace latelight
