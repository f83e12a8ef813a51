// Conversion of lists.
#include <algorithm>
#include <cmath>

#include "api/settings.h"
#include "api/worlds/converter.h"
#include "api/worlds/messages.h"
#include "scene/edit_check.h"
#include "scene/file_frame.h"
#include "scene/lens.h"

namespace latelight {

namespace {

// Calls `convert` for a world, which the message of a rejected value names.
template <typename Convert>
void inWorld(size_t world, const Convert& convert) {
  try {
    convert();
  } catch (const Error& error) {
    if (error.code() != ExitCode::Usage) throw;
    throw Error(ExitCode::Usage, fmt::format("world {}: {}", world, error.what()));
  }
}

// The ranges that glTF 2.0 gives factors, except that colors may exceed 1.
bool areInRange(const MaterialFactors& factors) {
  const auto isColor = [](float value) { return value >= 0; };
  const auto isShare = [](float value) { return value >= 0 && value <= 1; };
  return std::ranges::all_of(factors.baseColor, isColor) && std::ranges::all_of(factors.emissive, isColor) &&
         isShare(factors.metallic) && isShare(factors.roughness);
}

}  // namespace

void Scene::Impl::WorldConverter::convertMaterials() const {
  for (const Handle<Material>& material : from.materials) to.materials.push_back(scene.index(material));
  for (size_t i = 0; i < from.factors.size(); ++i) {
    const size_t world = i / to.instances.size();
    const MaterialFactors values = invalid[world] ? MaterialFactors{} : from.factors[i];
    if (!areInRange(values)) badUsage(kWrongFactors, world);
    const auto [r, g, b, alpha] = values.baseColor;
    const auto [x, y, z] = values.emissive;
    to.factors.push_back({.baseColor = {r, g, b, alpha},
                          .emissive = {x, y, z},
                          .metallic = values.metallic,
                          .roughness = values.roughness});
  }
}

void Scene::Impl::WorldConverter::convertLights() const {
  for (const Handle<Light>& light : from.lights) {
    to.lights.push_back(scene.index(light));
    if (std::ranges::count(to.lights, to.lights.back()) > 1)
      badUsage("the lights of worlds must be listed once each, and one is listed twice");
  }
  for (size_t i = 0; i < from.lightValues.size(); ++i) {
    const scene::Light& like = scene.scene.lights[to.lights[i % to.lights.size()]];
    if (invalid[i / to.lights.size()]) {
      to.lightValues.push_back(like);
      continue;
    }
    inWorld(i / to.lights.size(), [&] {
      to.lightValues.push_back(internalLight(from.lightValues[i], scene.scene, like));
      scene::checkLight(scene.scene, to.lightValues.back());
    });
  }
  to.environmentIndex = from.environmentIndex;
  for (size_t world = 0; world < from.environmentRotation.size(); ++world)
    to.environmentRotation.push_back(render::radians(invalid[world] ? 0 : from.environmentRotation[world]));
  for (size_t world = 0; world < from.environmentIntensity.size(); ++world) {
    const float intensity = invalid[world] ? 0 : from.environmentIntensity[world];
    if (intensity < 0) badUsage(kWrongEnvironment, world);
    to.environmentIntensity.push_back(intensity);
  }
}

std::vector<glm::dmat4> Scene::Impl::WorldConverter::transformsOf(const std::vector<Transform>& values) const {
  std::vector<glm::dmat4> transforms;
  transforms.reserve(values.size());
  const size_t each = to.instances.size();
  for (size_t i = 0; i < values.size(); ++i) {
    transforms.push_back(invalid[i / each] ? glm::dmat4(1) : internalTransform(values[i], scene.scene));
    inWorld(i / each, [&] { scene::checkTransform(transforms.back()); });
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
    if (!(length > 0)) badUsage(kWrongRide, world);
    frame[i] /= length;
  }
  if (!isRigid(frame, 1e-3)) badUsage(kWrongRide, world);
  return frame;
}

// Returns the camera's lens with another camera matrix: fx, fy, cx and cy, in pixels of the call's images. A camera
// without a lens gets a pinhole.
Lens Scene::Impl::WorldConverter::lensWith(const Camera& camera, const std::array<double, 4>& intrinsics) const {
  Lens lens = camera.lens.value_or(Lens{});
  const scene::LensModelInfo& model = scene::infoOf(static_cast<scene::LensModel>(lens.model));
  if (!model.calibrated)
    badUsage("a camera with the lens model {} has no focal lengths, which camera matrices of worlds would replace",
             model.name);
  if (camera.orthographic)
    badUsage("an orthographic camera has no focal lengths, which camera matrices of worlds would replace");
  lens.width = settings.width;
  lens.height = settings.height;
  lens.fx = intrinsics[0];
  lens.fy = intrinsics[1];
  lens.cx = intrinsics[2];
  lens.cy = intrinsics[3];
  return lens;
}

// `poses` replaces the cameras' own poses unless it is empty. `transforms` and `pose` are those of the same time.
std::vector<scene::Camera> Scene::Impl::WorldConverter::camerasAt(const std::vector<Transform>& poses,
                                                                  const std::vector<glm::dmat4>& transforms,
                                                                  const scene::Pose& pose) const {
  std::vector<scene::Camera> cameras;
  const size_t each = from.cameras.size();
  cameras.reserve(from.count * each);
  std::vector<glm::dmat4> scenes;  // transforms of the scene's instances
  if (!from.cameraInstances.empty()) scenes = scene::instanceTransforms(scene.scene, pose);
  for (size_t i = 0; i < from.count * each; ++i) {
    const auto world = static_cast<uint32_t>(i / each);
    Camera camera = from.cameras[i % each];
    if (!poses.empty() && !invalid[world]) camera.cameraToWorld = poses[i];
    if (!from.intrinsics.empty() && !invalid[world]) {
      const auto [fx, fy, cx, cy] = from.intrinsics[i];
      if (!(fx > 0 && fy > 0)) badUsage(kWrongIntrinsics, world);
      camera.lens = lensWith(camera, from.intrinsics[i]);
    }
    scene::Camera internal;
    inWorld(world, [&] { internal = render::fitted(internalCamera(camera, scene.scene), settings.cameraFit); });
    if (!from.cameraInstances.empty() && from.cameraInstances[i % each]) {
      // The pose relative to the instance's frame, in the renderer's axes.
      const glm::dmat4 relative = glm::inverse(scene::worldFromFile(scene.scene)) * internal.toWorld;
      internal.toWorld = frameOf(scene.index(*from.cameraInstances[i % each]), world, transforms, scenes) * relative;
    }
    internal.world = world;
    cameras.push_back(std::move(internal));
  }
  return cameras;
}

WorldCameras Scene::Impl::WorldConverter::convertOnHost(render::SceneState& state) {
  to.transforms = transformsOf(from.transforms);
  to.previous = transformsOf(from.previousTransforms);
  to.next = transformsOf(from.nextTransforms);
  to.exists = from.exists;
  convertMaterials();
  convertLights();
  to.empty = invalid;
  const auto orNow = [](const auto& values, const auto& now) -> const auto& {
    return values.empty() ? now : values;
  };
  const render::Poses& poses = state.poses;
  WorldCameras result;
  result.cameras = camerasAt(from.cameraToWorld, to.transforms, poses.current);
  // Otherwise the cameras do not move.
  if (!from.previousCameraToWorld.empty() || !from.cameraInstances.empty())
    state.previousCameras = camerasAt(orNow(from.previousCameraToWorld, from.cameraToWorld),
                                      orNow(to.previous, to.transforms), poses.previous);
  if (!from.nextCameraToWorld.empty() || !from.cameraInstances.empty())
    state.nextCameras =
        camerasAt(orNow(from.nextCameraToWorld, from.cameraToWorld), orNow(to.next, to.transforms), poses.next);
  for (uint32_t world = 0; world < from.count; ++world)
    if (invalid[world]) result.invalid.push_back(world);
  warnOfInvalidWorlds(result.invalid, from.count);
  return result;
}

}  // namespace latelight
