#include "render/gpu_scene.h"

#include <algorithm>

namespace latelight::render {

namespace {

bool deforms(const scene::Scene& scene) {
  return std::any_of(scene.meshes.begin(), scene.meshes.end(),
                     [](const scene::Mesh& mesh) { return mesh.deformation != nullptr; });
}

}  // namespace

GpuScene::GpuScene(vk::Device& device, const scene::Scene& scene) : GpuScene(device, scene, vk::Uploader(device)) {}

GpuScene::GpuScene(vk::Device& device, const scene::Scene& scene, vk::Uploader&& uploader)
    : device_(device),
      scene_(scene),
      geometry_(device, scene, uploader),
      instances_(device, scene, uploader),
      materials_(device, scene, uploader),
      lights_(device),
      seen_(revisionsOf(scene)) {
  lights_.set(uploader, scene.lights);
  uploader.flush();
}

GpuScene::Seen GpuScene::revisionsOf(const scene::Scene& scene) {
  return {scene.edits.meshes.revision(), scene.edits.materials.revision(), scene.edits.instances.revision(),
          scene.edits.lights.revision()};
}

void GpuScene::update(const Poses& poses, const std::optional<scene::Light>& sun) {
  vk::Uploader uploader(device_);
  const Seen now = revisionsOf(scene_);
  const bool poseChanges = posed_ || !poses.current.empty();
  const bool lightsMove = poseChanges && std::any_of(scene_.lights.begin(), scene_.lights.end(),
                                                     [](const scene::Light& light) { return light.node >= 0; });
  follow(uploader);
  if (poseChanges) pose(uploader, poses);
  if (lightsMove || now.lights != seen_.lights || sun != sun_) {
    sun_ = sun;
    std::vector<scene::Light> lights = scene::posedLights(scene_, poses.current);
    if (sun) lights.push_back(*sun);
    lights_.set(uploader, std::move(lights));
  }
  seen_ = now;
  uploader.flush();
}

void GpuScene::follow(vk::Uploader& uploader) {
  const scene::SceneEdits& edits = scene_.edits;
  if (const auto meshes = edits.meshes.since(seen_.meshes); !meshes.empty()) {
    geometry_.update(uploader, meshes);
    deformer_.reset();
    bounds_.reset();
    // The bounds of their instances follow.
    std::vector<uint32_t> moved;
    for (uint32_t i = 0; i < scene_.instances.size(); ++i)
      if (std::ranges::binary_search(meshes, scene_.instances[i].mesh)) moved.push_back(i);
    instances_.update(uploader, moved);
  }
  if (const auto materials = edits.materials.since(seen_.materials); !materials.empty())
    materials_.update(uploader, materials);
  if (const auto instances = edits.instances.since(seen_.instances); !instances.empty()) {
    instances_.update(uploader, instances);
    bounds_.reset();
  }
}

void GpuScene::pose(vk::Uploader& uploader, const Poses& poses) {
  posed_ = !poses.current.empty();
  bounds_.reset();
  if (deforms(scene_)) {
    if (!deformer_) deformer_ = std::make_unique<Deformer>(device_, scene_);
    if (posed_) deformer_->run(poses);
    geometry_.pose(uploader, posed_ ? deformer_.get() : nullptr);
  }
  instances_.pose(uploader, poses, deformer_.get());
}

void GpuScene::setLights(std::vector<scene::Light> lights) {
  vk::Uploader uploader(device_);
  lights_.set(uploader, std::move(lights));
  uploader.flush();
}

scene::Bounds GpuScene::bounds() const {
  if (!bounds_) bounds_ = posed_ ? instances_.allBounds() : scene::worldBounds(scene_);
  return *bounds_;
}

void GpuScene::describe(shared::FrameConstants& frame) const {
  instances_.describe(frame);
  lights_.describe(frame);
  frame.meshes = geometry_.address();
  frame.materials = materials_.address();
}

}  // namespace latelight::render
