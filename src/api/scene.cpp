// The scene of the public API: its file, its cameras and its environment.
#include "api/scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "api/settings.h"
#include "base/error.h"
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

Scene::Scene() : impl_(new Impl{scene::Scene{.name = "scene", .source = "scene"}}) {}

Scene::Scene(const std::string& source, const std::string& materialVariant)
    : Scene(source, SceneOptions{.materialVariant = materialVariant}) {}

Scene::Scene(const std::string& source, const SceneOptions& options)
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
void Scene::exportTo(const std::string& file) const {
  exports::exportScene(filled().scene, file);
}
void Scene::setEnvironment(const EnvironmentData& environment) {
  auto made = std::make_shared<scene::Environment>(makeEnvironment(environment));
  made->name = "environment of the scene";
  filled().scene.environment = std::move(made);
}
std::string Scene::idManifest() const {
  return output::idManifestText(render::idManifest(filled().scene));
}
const std::vector<Camera>& Scene::cameras() const {
  return filled().cameras;
}

const std::vector<Animation>& Scene::animations() const {
  return filled().animations;
}

Camera Scene::Impl::posedCamera(size_t index, const scene::Camera& posed) const {
  Camera camera = publicCamera(posed, scene);
  camera.shutter = cameras[index].shutter;
  camera.readout = cameras[index].readout;
  camera.exposure = cameras[index].exposure;
  return camera;
}

void Scene::addCamera(const Camera& camera) {
  shutterOf(camera, 0), readoutOf(camera, 0), exposureOf(camera, 0);  // reject invalid values
  const size_t index = filled().cameras.size();
  filled().scene.cameras.push_back(internalCamera(camera, filled().scene));
  filled().cameras.push_back(camera);
  filled().cameras[index] = filled().posedCamera(index, filled().scene.cameras[index]);
}

void Scene::addCamera(const Camera& camera, const std::string& node) {
  const uint32_t index = filled().nodeAt(node);
  scene::rigNodeOf(filled().scene, index);
  addCamera(camera);
  scene::Camera& added = filled().scene.cameras.back();
  added.node = static_cast<int>(index);
  filled().scene.nodes[index].followed = true;
  scene::placeCamera(added, scene::toGltfFromWorld() * filled().scene.nodes[index].toWorld);
  filled().cameras.back() = filled().posedCamera(filled().cameras.size() - 1, added);
}

std::vector<Camera> Scene::camerasAt(double time, const std::string& animation, bool loop) const {
  checkTime(time);
  const scene::Scene& scene = filled().scene;
  const scene::Pose pose = scene::poseAt(scene, scene::choosePlayback(scene, animation, loop), time);
  std::vector<Camera> cameras;
  for (const scene::Camera& posed : scene::posedCameras(scene, pose))
    cameras.push_back(filled().posedCamera(cameras.size(), posed));
  return cameras;
}

Camera Scene::defaultCamera(float aspect, std::optional<double> time, const std::string& animation, bool loop) const {
  if (!filled().cameras.empty()) return time ? camerasAt(*time, animation, loop).front() : filled().cameras.front();
  if (!(aspect > 0) || !std::isfinite(aspect)) badUsage("a picture's aspect must be a number above 0, not {}", aspect);
  return publicCamera(scene::frameScene(filled().scene, aspect), filled().scene);
}

Camera Scene::lookAt(std::array<double, 3> eye, std::array<double, 3> target, float verticalFov) const {
  return publicCamera(scene::lookAt(filled().scene, {eye[0], eye[1], eye[2]}, {target[0], target[1], target[2]}, {},
                                    verticalFovOf(verticalFov)),
                      filled().scene);
}

}  // namespace latelight
