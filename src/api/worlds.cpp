// Worlds of the public API: checks the lists, and converts them to the renderer's instances and cameras of all worlds.
#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numeric>

#include "api/scene.h"
#include "base/error.h"
#include "base/log.h"
#include "render/settings/settings.h"
#include "render/submit/scene_state.h"
#include "render/submit/session.h"
#include "scene/edit_check.h"
#include "scene/file_frame.h"

namespace latelight {

namespace {

bool isFinite(const Transform& transform) {
  return std::ranges::all_of(transform, [](double value) { return std::isfinite(static_cast<float>(value)); });
}

bool isFinite(const Light& light) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::ranges::all_of(light.position, finite) && std::ranges::all_of(light.direction, finite) &&
         std::ranges::all_of(light.color, finite) && finite(light.intensity);
}

bool isFinite(const MaterialFactors& factors) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::ranges::all_of(factors.baseColor, finite) && std::ranges::all_of(factors.emissive, finite) &&
         finite(factors.metallic) && finite(factors.roughness);
}

// `elements`: each world has a value per element, or a single one if it is empty.
void checkCount(size_t has, size_t worlds, size_t each, const char* list, std::string_view elements) {
  if (has == worlds * each || (has == 0 && each != 0)) return;
  badUsage("Worlds::{} must have {} values, one per world{}{}, and has {}", list, worlds * each,
           elements.empty() ? "" : " and ", elements, has);
}

}  // namespace

// Converts one call's worlds.
struct Scene::Impl::WorldConverter {
  const Worlds& from;
  const Impl& scene;
  const render::Settings& settings;
  render::WorldStates& to;
  std::vector<uint32_t> placeOf{};  // index in `instances` per instance of the scene; ~0u: not listed
  std::vector<uint8_t> invalid{};   // per world

  void check() const;
  void listInstances();
  void findInvalid();
  void convertMaterials() const;
  void convertLights() const;
  std::vector<glm::dmat4> transformsOf(const std::vector<Transform>& values) const;
  glm::dmat4 frameOf(uint32_t instance, uint32_t world, const std::vector<glm::dmat4>& transforms,
                     const std::vector<glm::dmat4>& scenes) const;
  std::vector<scene::Camera> camerasAt(const std::vector<Transform>& poses, const std::vector<glm::dmat4>& transforms,
                                       const scene::Pose& pose) const;
};

void Scene::Impl::WorldConverter::check() const {
  if (from.count == 0) badUsage("Worlds::count must be at least 1");
  if (from.cameras.empty()) badUsage("Worlds::cameras must have at least one camera");
  const size_t instances = to.instances.size(), cameras = from.cameras.size();
  checkCount(from.transforms.size(), from.count, instances, "transforms", "instance");
  checkCount(from.previousTransforms.size(), from.count, instances, "previousTransforms", "instance");
  checkCount(from.nextTransforms.size(), from.count, instances, "nextTransforms", "instance");
  checkCount(from.exists.size(), from.count, instances, "exists", "instance");
  checkCount(from.materials.size(), from.count, instances, "materials", "instance");
  checkCount(from.factors.size(), from.count, instances, "factors", "instance");
  checkCount(from.lightValues.size(), from.count, from.lights.size(), "lightValues", "light");
  checkCount(from.environmentRotation.size(), from.count, 1, "environmentRotation", "");
  checkCount(from.environmentIntensity.size(), from.count, 1, "environmentIntensity", "");
  checkCount(from.cameraToWorld.size(), from.count, cameras, "cameraToWorld", "camera");
  checkCount(from.previousCameraToWorld.size(), from.count, cameras, "previousCameraToWorld", "camera");
  checkCount(from.nextCameraToWorld.size(), from.count, cameras, "nextCameraToWorld", "camera");
  checkCount(from.intrinsics.size(), from.count, cameras, "intrinsics", "camera");
  if (from.transforms.empty() && !(from.previousTransforms.empty() && from.nextTransforms.empty()))
    badUsage("Worlds::previousTransforms and nextTransforms require transforms");
  if (!from.cameraInstances.empty() && from.cameraInstances.size() != cameras)
    badUsage("Worlds::cameraInstances must have one value per camera, {}, and has {}", cameras,
             from.cameraInstances.size());
}

void Scene::Impl::WorldConverter::listInstances() {
  to.count = from.count;
  for (const Handle<Instance>& instance : from.instances) to.instances.push_back(scene.index(instance));
  if (from.instances.empty())
    for (uint32_t i = 0; i < scene.scene.instances.size(); ++i)
      if (!scene.scene.instances[i].removed) to.instances.push_back(i);
  placeOf.assign(scene.scene.instances.size(), ~0u);
  for (uint32_t i = 0; i < to.instances.size(); ++i) {
    if (placeOf[to.instances[i]] != ~0u) badUsage("Worlds::instances lists an instance twice");
    placeOf[to.instances[i]] = i;
  }
}

// A world with a value that is not finite has no instances. Its cameras see only the background.
void Scene::Impl::WorldConverter::findInvalid() {
  invalid.assign(from.count, 0);
  const auto mark = [&](const std::vector<Transform>& values) {
    for (size_t i = 0; i < values.size(); ++i)
      if (!isFinite(values[i])) invalid[i / (values.size() / from.count)] = 1;
  };
  for (const auto* values : {&from.transforms, &from.previousTransforms, &from.nextTransforms, &from.cameraToWorld,
                             &from.previousCameraToWorld, &from.nextCameraToWorld})
    mark(*values);
  for (size_t i = 0; i < from.factors.size(); ++i)
    if (!isFinite(from.factors[i])) invalid[i / to.instances.size()] = 1;
  for (size_t i = 0; i < from.lightValues.size(); ++i)
    if (!isFinite(from.lightValues[i])) invalid[i / from.lights.size()] = 1;
  for (size_t world = 0; world < from.environmentRotation.size(); ++world)
    if (!std::isfinite(from.environmentRotation[world])) invalid[world] = 1;
  for (size_t world = 0; world < from.environmentIntensity.size(); ++world)
    if (!std::isfinite(from.environmentIntensity[world])) invalid[world] = 1;
  for (size_t i = 0; i < from.intrinsics.size(); ++i)
    if (!std::ranges::all_of(from.intrinsics[i], [](double value) { return std::isfinite(value); }))
      invalid[i / from.cameras.size()] = 1;
}

void Scene::Impl::WorldConverter::convertMaterials() const {
  for (const Handle<Material>& material : from.materials) to.materials.push_back(scene.index(material));
  for (size_t i = 0; i < from.factors.size(); ++i) {
    const MaterialFactors values = invalid[i / to.instances.size()] ? MaterialFactors{} : from.factors[i];
    const auto [r, g, b, alpha] = values.baseColor;
    const auto [x, y, z] = values.emissive;
    scene::Material checked{.name = "Worlds::factors"};
    checked.data =
        scene.scene
            .materials[to.materials.empty() ? scene.scene.instances[to.instances[i % to.instances.size()]].material
                                            : to.materials[i]]
            .data;
    checked.data.baseColor = {r, g, b, alpha};
    checked.data.emissive = {x, y, z};
    checked.data.metallic = values.metallic;
    checked.data.roughness = values.roughness;
    scene::checkMaterial(scene.scene, checked);
    to.factors.push_back({.baseColor = checked.data.baseColor,
                          .emissive = checked.data.emissive,
                          .metallic = values.metallic,
                          .roughness = values.roughness});
  }
}

void Scene::Impl::WorldConverter::convertLights() const {
  for (const Handle<Light>& light : from.lights) to.lights.push_back(scene.index(light));
  for (size_t i = 0; i < from.lightValues.size(); ++i) {
    const scene::Light& like = scene.scene.lights[to.lights[i % to.lights.size()]];
    if (invalid[i / to.lights.size()]) {
      to.lightValues.push_back(like);
      continue;
    }
    to.lightValues.push_back(internalLight(from.lightValues[i], scene.scene, like));
    scene::checkLight(scene.scene, to.lightValues.back());
  }
  for (size_t world = 0; world < from.environmentRotation.size(); ++world)
    to.environmentRotation.push_back(render::radians(invalid[world] ? 0 : from.environmentRotation[world]));
  for (size_t world = 0; world < from.environmentIntensity.size(); ++world) {
    const float intensity = invalid[world] ? 0 : from.environmentIntensity[world];
    if (intensity < 0) badUsage("Worlds::environmentIntensity must be at least 0, not {}", intensity);
    to.environmentIntensity.push_back(intensity);
  }
}

std::vector<glm::dmat4> Scene::Impl::WorldConverter::transformsOf(const std::vector<Transform>& values) const {
  std::vector<glm::dmat4> transforms;
  transforms.reserve(values.size());
  const size_t each = to.instances.size();
  for (size_t i = 0; i < values.size(); ++i) {
    transforms.push_back(invalid[i / each] ? glm::dmat4(1) : internalTransform(values[i], scene.scene));
    scene::checkTransform(transforms.back());
  }
  return transforms;
}

// Returns the instance's frame in a world, without scale, in the renderer's world space. `scenes`: the transforms of
// the scene's instances.
glm::dmat4 Scene::Impl::WorldConverter::frameOf(uint32_t instance, uint32_t world,
                                                const std::vector<glm::dmat4>& transforms,
                                                const std::vector<glm::dmat4>& scenes) const {
  const uint32_t place = placeOf[instance];
  const bool own = place != ~0u && !transforms.empty();
  glm::dmat4 frame = own ? transforms[size_t{world} * to.instances.size() + place] : scenes[instance];
  for (int i = 0; i < 3; ++i) {
    const double length = glm::length(glm::dvec3(frame[i]));
    if (!(length > 0)) badUsage("a camera rides on an instance whose transform has an axis of length 0");
    frame[i] /= length;
  }
  if (glm::determinant(glm::dmat3(frame)) < 0) badUsage("a camera rides on an instance whose transform mirrors");
  return frame;
}

// `poses` replaces the cameras' own poses unless it is empty. `transforms` and `pose` are those of the same time.
std::vector<scene::Camera> Scene::Impl::WorldConverter::camerasAt(const std::vector<Transform>& poses,
                                                                  const std::vector<glm::dmat4>& transforms,
                                                                  const scene::Pose& pose) const {
  std::vector<scene::Camera> cameras;
  const size_t each = from.cameras.size();
  std::vector<glm::dmat4> scenes;  // transforms of the scene's instances
  if (!from.cameraInstances.empty()) scenes = scene::instanceTransforms(scene.scene, pose);
  for (size_t i = 0; i < from.count * each; ++i) {
    const auto world = static_cast<uint32_t>(i / each);
    Camera camera = from.cameras[i % each];
    if (!poses.empty() && !invalid[world]) camera.cameraToWorld = poses[i];
    if (!from.intrinsics.empty() && !invalid[world]) {
      const auto [fx, fy, cx, cy] = from.intrinsics[i];
      camera.lens = Lens{
          .width = double(settings.width), .height = double(settings.height), .fx = fx, .fy = fy, .cx = cx, .cy = cy};
    }
    scene::Camera internal = render::fitted(internalCamera(camera, scene.scene), settings.cameraFit);
    const bool rides = !from.cameraInstances.empty() && from.cameraInstances[i % each];
    if (rides) {
      // The pose relative to the instance's frame, in the renderer's axes.
      const glm::dmat4 relative = glm::inverse(scene::worldFromFile(scene.scene)) * internal.toWorld;
      internal.toWorld = frameOf(scene.index(*from.cameraInstances[i % each]), world, transforms, scenes) * relative;
    }
    internal.world = world;
    cameras.push_back(std::move(internal));
  }
  return cameras;
}

WorldCameras Scene::Impl::convert(const Worlds& worlds, const render::Settings& settings,
                                  render::SceneState& state) const {
  WorldConverter converter{worlds, *this, settings, state.worlds};
  converter.listInstances();
  converter.check();
  converter.findInvalid();
  render::WorldStates& to = state.worlds;
  to.transforms = converter.transformsOf(worlds.transforms);
  to.previous = converter.transformsOf(worlds.previousTransforms);
  to.next = converter.transformsOf(worlds.nextTransforms);
  to.exists = worlds.exists;
  converter.convertMaterials();
  converter.convertLights();
  to.empty = converter.invalid;
  const auto orNow = [](const auto& values, const auto& now) -> const auto& {
    return values.empty() ? now : values;
  };
  const render::Poses& poses = state.poses;
  WorldCameras result;
  result.cameras = converter.camerasAt(worlds.cameraToWorld, to.transforms, poses.current);
  // Otherwise the cameras do not move.
  if (!worlds.previousCameraToWorld.empty() || !worlds.cameraInstances.empty())
    state.previousCameras = converter.camerasAt(orNow(worlds.previousCameraToWorld, worlds.cameraToWorld),
                                                orNow(to.previous, to.transforms), poses.previous);
  if (!worlds.nextCameraToWorld.empty() || !worlds.cameraInstances.empty())
    state.nextCameras = converter.camerasAt(orNow(worlds.nextCameraToWorld, worlds.cameraToWorld),
                                            orNow(to.next, to.transforms), poses.next);
  for (uint32_t world = 0; world < worlds.count; ++world)
    if (converter.invalid[world]) result.invalid.push_back(world);
  if (!result.invalid.empty())
    warn("{} of {} worlds have values that are not finite, and show only the background; the first is world {}",
         result.invalid.size(), worlds.count, result.invalid.front());
  return result;
}

}  // namespace latelight
