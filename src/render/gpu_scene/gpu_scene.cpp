#include "render/gpu_scene/gpu_scene.h"

#include <algorithm>

namespace latelight::render {

namespace {

bool deforms(const scene::Scene& scene) {
  return std::any_of(scene.meshes.begin(), scene.meshes.end(),
                     [](const scene::Mesh& mesh) { return mesh.deformation != nullptr; });
}

// Returns true if a pose may change the position or the values of lights.
bool posesLights(const scene::Scene& scene) {
  const auto changesLights = [](const scene::Animation& animation) {
    return std::ranges::count(animation.values, scene::AnimatedElements::Lights, &scene::ValueTrack::elements) > 0;
  };
  return std::ranges::any_of(scene.lights, [](const scene::Light& light) { return light.node >= 0; }) ||
         std::ranges::any_of(scene.rig.animations, changesLights);
}

}  // namespace

GpuScene::GpuScene(vk::Device& device, const scene::Scene& scene) : GpuScene(device, scene, vk::Uploader(device)) {}

GpuScene::GpuScene(vk::Device& device, const scene::Scene& scene, vk::Uploader&& uploader)
    : device_(device),
      scene_(scene),
      geometry_(device, scene, uploader),
      instances_(device, scene, uploader),
      worlds_(device),
      materials_(device, scene, uploader),
      lights_(device),
      objectFrames_(device, scene),
      worldDeformer_(device),
      uploads_(device, vk::UploadMode::Deferred),
      seen_(revisionsOf(scene)) {
  lightsOrigin_ = origin();
  lights_.set(uploader, scene::posedLights(scene, {}), origin());
  countLights();
  uploader.flush();
}

GpuScene::Seen GpuScene::revisionsOf(const scene::Scene& scene) {
  return {scene.edits.meshes.revision(), scene.edits.materials.revision(), scene.edits.textures.revision(),
          scene.edits.instances.revision(), scene.edits.lights.revision()};
}

void GpuScene::update(const Poses& poses, const std::optional<scene::Light>& sun) {
  const Seen now = revisionsOf(scene_);
  const bool poseChanges = posed_ || !poses.current.empty();
  const bool lightsMove = poseChanges && posesLights(scene_);
  follow(std::exchange(isBehind_, true));
  if (poseChanges) pose(poses);
  if (lightsMove || now.lights != seen_.lights || sun != sun_ || lightsOrigin_ != origin()) {
    seen_.lights = ~uint64_t{0};  // so that a call after a failure repeats this
    sun_ = sun;
    lightsOrigin_ = origin();
    lights_.set(uploads_, lightsIn(poses), origin());
    countLights();
  }
  seen_ = now;
  isBehind_ = false;
}

std::vector<scene::Light> GpuScene::lightsIn(const Poses& poses) const {
  std::vector<scene::Light> lights = scene::posedLights(scene_, poses.current);
  if (sun_) lights.push_back(*sun_);
  return lights;
}

void GpuScene::countLights() {
  lightCount_ = localLights_ = unboundedLights_ = areaLights_ = 0;
  const auto count = [&](const LightSet& set) {
    const auto all = static_cast<uint32_t>(set.lights.size());
    lightCount_ = std::max(lightCount_, all);
    localLights_ = std::max(localLights_, all - set.directional);
    unboundedLights_ = std::max(unboundedLights_, set.unbounded);
    areaLights_ = std::max(areaLights_, static_cast<uint32_t>(set.area.size()));
  };
  if (worlds_.placesLights()) {  // upper bounds
    const GpuWorlds::PlacedLights& placed = worlds_.placedLights();
    lightCount_ = placed.directional + placed.local;
    localLights_ = placed.local;
    unboundedLights_ = placed.unbounded;
    areaLights_ = placed.area;
  } else if (worlds_.hasLights()) {
    std::ranges::for_each(worlds_.lights(), count);
  } else {
    count(lights_.set());
  }
}

void GpuScene::deformWorlds(const WorldStates& worlds, const Poses& poses) {
  if (worlds.deformations.empty()) return worldDeformer_.clear();
  if (!worlds.deformations.joints.empty() && !deformer_)
    deformer_ = std::make_unique<Deformer>(device_, scene_, uploads_);
  worldDeformer_.update(scene_, worlds.deformations, worlds.count, poses, deformer_.get(), geometry_, uploads_);
}

void GpuScene::setWorlds(const WorldStates& worlds, const Poses& poses, std::vector<uint32_t> environmentMaps) {
  worlds_.setEnvironments(uploads_, std::move(environmentMaps));
  deformWorlds(worlds, poses);
  if (worlds.count == 0) {
    worlds_.clear();
    materials_.setVariants(uploads_, {});
  } else {
    materials_.setVariants(uploads_, variantsOf(worlds, scene_));
    if (worlds.inputs && worlds.inputs->hasFactors())
      materials_.reserveDerived(uploads_, size_t{worlds.count} * worlds.instances.size());
    worlds_.update(uploads_, scene_, instances_, worlds, poses, posed_ ? deformer_.get() : nullptr, worldDeformer_);
    worlds_.updateLights(uploads_, worlds, worlds.lights.empty() ? std::vector<scene::Light>{} : lightsIn(poses),
                         scene_, origin());
    worlds_.updateValues(uploads_);
  }
  countLights();
  if (areaLights_ > 0) lights_.storeLtcTable(uploads_);
}

InstancesOfWorld GpuScene::instancesOf(uint32_t world) const {
  if (worlds_.onDevice()) return {instances_.records(), instances_.allSpheres(), worlds_.address(world)};
  if (hasWorlds()) return worlds_.of(world);
  return {instances_.records(), instances_.allSpheres(), instances_.address()};
}

void GpuScene::addChanges(graph::Graph& graph) const {
  if (!uploads_.empty())
    graph.prologue(graph::Stage::Upload, "upload", [this](graph::Context& context) { uploads_.record(context.get()); });
  if (deformationWaits_) deformer_->addTo(graph);
  if (worldDeformer_.isPending() && !worlds_.onDevice()) worldDeformer_.addTo(graph, 0);
}

void GpuScene::changesSubmitted() {
  uploads_.forget();
  deformationWaits_ = false;
  worldDeformer_.submitted();
}

void GpuScene::follow(bool all) {
  const scene::SceneEdits& edits = scene_.edits;
  const auto meshes = all ? allOf(scene_.meshes.size()) : edits.meshes.since(seen_.meshes);
  if (!meshes.empty()) {
    geometry_.update(uploads_, meshes);
    deformer_.reset();
    worldDeformer_.clear();
    deformationWaits_ = false;
    bounds_.reset();
    // The bounds of the instances of these meshes change, too.
    std::vector<uint32_t> moved;
    for (uint32_t i = 0; i < scene_.instances.size(); ++i)
      if (std::ranges::binary_search(meshes, scene_.instances[i].mesh)) moved.push_back(i);
    instances_.update(uploads_, moved);
  }
  const auto textures = all ? allOf(scene_.textures.size()) : edits.textures.since(seen_.textures);
  const auto materials = all ? allOf(scene_.materials.size()) : edits.materials.since(seen_.materials);
  if (!textures.empty() || !materials.empty()) materials_.update(uploads_, textures, materials);
  const auto instances = all ? allOf(scene_.instances.size()) : edits.instances.since(seen_.instances);
  if (!instances.empty()) {
    instances_.update(uploads_, instances);
    bounds_.reset();
  }
  if (!meshes.empty() || !instances.empty()) materials_.updateOpacity(uploads_, meshes);
}

void GpuScene::pose(const Poses& poses) {
  const bool posed = !poses.current.empty();
  posed_ = true;  // until all uploads have succeeded, so that a call after a failure repeats them
  bounds_.reset();
  if (deforms(scene_)) {
    if (!deformer_) deformer_ = std::make_unique<Deformer>(device_, scene_, uploads_);
    if (posed) deformer_->pose(poses);
    deformationWaits_ = posed;
    geometry_.pose(uploads_, posed ? deformer_.get() : nullptr);
  }
  instances_.pose(uploads_, poses, deformer_.get());
  materials_.pose(uploads_, scene::posedMaterials(scene_, poses.current));
  posed_ = posed;
}

void GpuScene::setLights(std::vector<scene::Light> lights) {
  vk::Uploader uploader(device_);
  lights_.set(uploader, std::move(lights), origin());
  countLights();
  uploader.flush();
}

scene::Bounds GpuScene::bounds(uint32_t world) const {
  if (hasWorlds() && !worlds_.onDevice()) return worlds_.bounds(world);
  if (!bounds_) bounds_ = posed_ ? instances_.allBounds() : scene::worldBounds(scene_);
  return *bounds_;
}

scene::Bounds GpuScene::deviceBounds(uint32_t world) const {
  scene::Bounds all = bounds(world);
  all.min -= origin();
  all.max -= origin();
  return all;
}

uint32_t GpuScene::traits() const {
  const bool noExtras = device_.hasCpuShaders() && !geometry_.hasExtras();
  return materials_.traits() | (noExtras ? shared::kTraitNoExtras : 0u);
}

void GpuScene::describe(shared::FrameConstants& frame, uint32_t world) const {
  if (hasWorlds())
    worlds_.describe(frame, world);
  else
    instances_.describe(frame);
  lights_.describe(frame);
  if (worlds_.hasLights() || worlds_.placesLights()) worlds_.describeLights(frame, world);
  frame.meshes = geometry_.address();
  frame.materials = materials_.address();
  frame.textures = materials_.textureRecords();
}

}  // namespace latelight::render
