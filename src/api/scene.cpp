// The scene of the public API: its file, its cameras and its environment.
#include "api/scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <utility>

#include "api/settings.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/reserve.h"
#include "export/export.h"
#include "output/id_manifest.h"
#include "render/submit/id_manifest.h"
#include "scene/environment/environment.h"
#include "scene/framing.h"
#include "scene/load/load.h"
#include "scene/rig_edit.h"

namespace latelight {

namespace {

void checkTime(double time) {
  if (!std::isfinite(time)) badUsage("the time must be a number of seconds");
}

// Returns the camera converted. Throws Error(Usage) for invalid values, also of those that scene::Camera does not have.
scene::Camera checkedCamera(const Camera& camera, const scene::Scene& scene) {
  shutterOf(camera, 0), readoutOf(camera, 0), exposureOf(camera, 0);
  return internalCamera(camera, scene);
}

}  // namespace

scene::Environment makeEnvironment(const EnvironmentData& data) {
  if (data.height == 0 || data.width != 2 * data.height)
    badUsage("an environment is twice as wide as it is high, and not {}x{} pixels", data.width, data.height);
  if (data.radiance.size() != size_t{data.width} * data.height)
    badUsage("an environment of {}x{} pixels needs one radiance per pixel, but {} are given", data.width, data.height,
             data.radiance.size());
  scene::FloatImage picture(data.width, data.height);
  for (size_t i = 0; i < data.radiance.size(); ++i)
    for (size_t channel = 0; channel < 4; ++channel)
      picture.pixels[4 * i + channel] = channel < 3 ? data.radiance[i][channel] : 1;
  return scene::makeEnvironment(std::move(picture));
}

Scene::Scene() try : impl_(new Impl{scene::Scene{.name = "scene", .source = "scene"}}) {
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Scene::Scene(const std::string& source, const std::string& materialVariant)
    : Scene(source, SceneOptions{.materialVariant = materialVariant}) {}

Scene::Scene(const std::string& source, const SceneOptions& options) try
    : impl_(new Impl{scene::load(source, {.variant = options.materialVariant,
                                          .allowOutside = options.allowOutside,
                                          .ids = {options.idDepth, options.idNodes},
                                          .unit = options.unit,
                                          .upAxis = options.upAxis,
                                          .pointRadius = options.pointRadius,
                                          .morphTargets = true})}) {
  for (const scene::Animation& animation : impl_->scene.rig.animations)
    impl_->animations.push_back({animation.name, animation.duration});
  for (const scene::Camera& camera : impl_->scene.cameras) impl_->cameras.push_back(publicCamera(camera, impl_->scene));
} catch (const std::bad_alloc&) {
  failWithoutMemory(fmt::format("the scene {}", source));
}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

Scene::Impl& Scene::filled() const {
  if (!impl_) badUsage("this scene has been moved to another object: use that one");
  return *impl_;
}

uint64_t Scene::triangleCount() const {
  return filled().scene.triangleCount();
}
void Scene::exportTo(const std::string& file) const try {
  exports::exportScene(filled().scene, file);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}
void Scene::setEnvironment(const EnvironmentData& environment) try {
  auto made = std::make_shared<scene::Environment>(makeEnvironment(environment));
  made->name = "environment of the scene";
  filled().scene.environment = std::move(made);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}
std::string Scene::idManifest() const try {
  return output::idManifestText(render::idManifest(filled().scene));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}
const std::vector<Camera>& Scene::cameras() const {
  return filled().cameras;
}

const std::vector<Animation>& Scene::animations() const {
  return filled().animations;
}

Camera Scene::Impl::posedCamera(const Camera& like, const scene::Camera& posed) const {
  Camera camera = publicCamera(posed, scene);
  camera.shutter = like.shutter;
  camera.readout = like.readout;
  camera.exposure = like.exposure;
  return camera;
}

Camera Scene::Impl::posedCamera(size_t index, const scene::Camera& posed) const {
  return posedCamera(cameras[index], posed);
}

void Scene::Impl::addCamera(const Camera& camera, scene::Camera&& converted) {
  Camera added = posedCamera(camera, converted);
  reserveMore(scene.cameras, 1);
  reserveMore(cameras, 1);
  scene.cameras.push_back(std::move(converted));
  cameras.push_back(std::move(added));
}

void Scene::addCamera(const Camera& camera) try {
  filled().addCamera(camera, checkedCamera(camera, filled().scene));
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

void Scene::addCamera(const Camera& camera, const std::string& node) try {
  const uint32_t index = filled().nodeAt(node);
  scene::rigNodeOf(filled().scene, index);
  scene::Camera added = checkedCamera(camera, filled().scene);
  added.node = static_cast<int>(index);
  scene::placeCamera(added, scene::toGltfFromWorld() * filled().scene.nodes[index].toWorld);
  filled().addCamera(camera, std::move(added));
  filled().scene.nodes[index].followed = true;
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

std::vector<Camera> Scene::camerasAt(double time, const std::string& animation, bool loop) const try {
  checkTime(time);
  const scene::Scene& scene = filled().scene;
  const scene::Pose pose = scene::poseAt(scene, scene::choosePlayback(scene, animation, loop), time);
  std::vector<Camera> cameras;
  for (const scene::Camera& posed : scene::posedCameras(scene, pose))
    cameras.push_back(filled().posedCamera(cameras.size(), posed));
  return cameras;
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Camera Scene::defaultCamera(float aspect, std::optional<double> time, const std::string& animation, bool loop) const
    try {
  if (!(aspect > 0) || !std::isfinite(aspect)) badUsage("a picture's aspect must be a number above 0, not {}", aspect);
  if (!filled().cameras.empty()) return time ? camerasAt(*time, animation, loop).front() : filled().cameras.front();
  return publicCamera(scene::frameScene(filled().scene, aspect), filled().scene);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

Camera Scene::lookAt(std::array<double, 3> eye, std::array<double, 3> target, float verticalFov) const try {
  return publicCamera(scene::lookAt(filled().scene, {eye[0], eye[1], eye[2]}, {target[0], target[1], target[2]}, {},
                                    verticalFovOf(verticalFov)),
                      filled().scene);
} catch (const std::bad_alloc&) {
  failWithoutMemory(kSceneMemory);
}

}  // namespace latelight
