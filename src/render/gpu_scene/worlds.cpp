// A world's records equal those of the scene edited to the world's state, so both give the same bytes. They differ only
// in the origin, which is the scene's for all worlds.
#include "render/gpu_scene/worlds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <tuple>

#include "base/parallel.h"
#include "render/gpu_scene/light_tree.h"
#include "render/gpu_scene/world_inputs_push.h"
#include "scene/file_frame.h"
#include "shared/color.h"
#include "shared/light.h"

namespace latelight::render {

static_assert(shared::kInstanceAbsent > shared::kInstanceVast &&
              shared::kInstanceAbsent < 1u << shared::kInstanceGroupShift);

namespace {

constexpr size_t kInstancesPerTask = 4096, kLightSetsPerTask = 64;  // so that waking a thread is worthwhile

size_t worldsPerTask(size_t instances) {
  return std::max<size_t>(1, kInstancesPerTask / std::max<size_t>(1, instances));
}

// The scene's instances in one world.
struct WorldState {
  std::vector<glm::dmat4> transforms;
  std::vector<uint8_t> exists;
  std::vector<uint32_t> materials;  // indices of GpuMaterials
};

// Replaces the listed instances' transforms by those of a world.
void moveTo(std::vector<glm::dmat4>& transforms, const WorldStates& worlds, const std::vector<glm::dmat4>& values,
            uint32_t world) {
  if (values.empty()) return;
  const size_t listed = worlds.instances.size();
  for (size_t i = 0; i < listed; ++i) transforms[worlds.instances[i]] = values[world * listed + i];
}

WorldState stateOf(const WorldStates& worlds, uint32_t world, const scene::Scene& scene,
                   const std::vector<glm::dmat4>& transforms) {
  WorldState state{transforms, std::vector<uint8_t>(transforms.size(), 1), {}};
  for (const scene::Instance& instance : scene.instances) state.materials.push_back(instance.material);
  moveTo(state.transforms, worlds, worlds.transforms, world);
  const size_t listed = worlds.instances.size();
  for (size_t i = 0; !worlds.exists.empty() && i < listed; ++i)
    state.exists[worlds.instances[i]] = worlds.exists[world * listed + i];
  for (size_t i = 0; !worlds.materials.empty() && i < listed; ++i)
    state.materials[worlds.instances[i]] = worlds.materials[world * listed + i];
  for (size_t i = 0; !worlds.factors.empty() && i < listed; ++i)
    state.materials[worlds.instances[i]] = static_cast<uint32_t>(scene.materials.size() + world * listed + i);
  if (!worlds.empty.empty() && worlds.empty[world]) std::ranges::fill(state.exists, uint8_t{0});
  return state;
}

// Returns the material of each listed instance in each world, or nothing if worlds have the scene's materials.
std::vector<uint32_t> choicesOf(const WorldStates& worlds, const scene::Scene& scene) {
  std::vector<uint32_t> choices = worlds.materials;
  if (worlds.factors.empty()) return choices;
  choices.resize(worlds.factors.size());
  std::iota(choices.begin(), choices.end(), static_cast<uint32_t>(scene.materials.size()));
  return choices;
}

std::array<const WorldArray*, 19> arraysOf(const WorldInputs& inputs) {
  return {&inputs.transforms,
          &inputs.previous,
          &inputs.next,
          &inputs.cameraToWorld,
          &inputs.previousCameraToWorld,
          &inputs.nextCameraToWorld,
          &inputs.intrinsics,
          &inputs.baseColor,
          &inputs.metallic,
          &inputs.roughness,
          &inputs.emissive,
          &inputs.materialChoice,
          &inputs.lightPosition,
          &inputs.lightDirection,
          &inputs.lightColor,
          &inputs.lightIntensity,
          &inputs.environmentRotation,
          &inputs.environmentIntensity,
          &inputs.environmentIndex};
}

bool haveSameType(const WorldArray* a, const WorldArray* b) {
  return (a->address == 0) == (b->address == 0) && a->rows == b->rows && a->element == b->element;
}

bool differInArraysOnly(const WorldDeformations& a, const WorldDeformations& b) {
  const auto haveSameTypes = [](const WorldArray(&these)[3], const WorldArray(&those)[3]) {
    return std::ranges::equal(these, those,
                              [](const WorldArray& x, const WorldArray& y) { return haveSameType(&x, &y); });
  };
  return a.joints == b.joints && a.meshes == b.meshes && a.jointNumbers == b.jointNumbers &&
         a.vertexNumbers == b.vertexNumbers && haveSameTypes(a.jointTransforms, b.jointTransforms) &&
         haveSameTypes(a.vertices, b.vertices);
}

bool differInArraysOnly(const WorldInputs& a, const WorldInputs& b) {
  return std::ranges::equal(arraysOf(a), arraysOf(b), haveSameType) && (a.exists == 0) == (b.exists == 0) &&
         a.palette == b.palette && a.lights == b.lights && a.cameras == b.cameras && a.rides == b.rides;
}

}  // namespace

bool differInArraysOnly(const WorldStates& a, const WorldStates& b) {
  // Lists of values are empty if there are inputs, or describe what inputs do not.
  const auto lists = [](const WorldStates& w) {
    return std::tie(w.count, w.instances, w.transforms, w.previous, w.next, w.exists, w.materials, w.factors, w.empty,
                    w.lights, w.lightValues, w.environmentRotation, w.environmentIntensity, w.environments,
                    w.environmentIndex);
  };
  return a.inputs && b.inputs && lists(a) == lists(b) && differInArraysOnly(a.deformations, b.deformations) &&
         differInArraysOnly(*a.inputs, *b.inputs);
}

scene::Bounds boundsAtRest(const scene::Scene& scene, const WorldStates& worlds, uint32_t world) {
  scene::Bounds all;
  if (!worlds.empty.empty() && worlds.empty[world]) return all;
  std::vector<glm::dmat4> transforms;
  for (const scene::Instance& instance : scene.instances) transforms.push_back(instance.toWorld);
  const WorldState state = stateOf(worlds, world, scene, transforms);
  std::map<uint32_t, scene::Mesh> moved;  // by mesh
  for (size_t i = 0; i < worlds.deformations.meshes.size(); ++i) {
    scene::Mesh& mesh = moved[worlds.deformations.meshes[i]];
    mesh.positions = worlds.deformations.verticesIn(world, scene, i);
    scene::findBounds(mesh);
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const scene::Instance& instance = scene.instances[i];
    const auto found = moved.find(instance.mesh);
    const scene::Mesh& mesh = found == moved.end() ? scene.meshes[instance.mesh] : found->second;
    if (state.exists[i] && scene::isShown(scene, {}, instance) && !mesh.positions.empty())
      scene::addBox(mesh.boundsMin, mesh.boundsMax, state.transforms[i], all);
  }
  return all;
}

std::vector<GpuMaterials::Variant> variantsOf(const WorldStates& worlds, const scene::Scene& scene) {
  std::vector<GpuMaterials::Variant> variants;
  const size_t listed = worlds.instances.size();
  for (size_t i = 0; i < worlds.factors.size(); ++i) {
    const uint32_t own = scene.instances[worlds.instances[i % listed]].material;
    variants.push_back({worlds.materials.empty() ? own : worlds.materials[i], worlds.factors[i]});
  }
  return variants;
}

// Shaders write the lists. The revision tells those who refer to them only what else has changed.
void GpuWorlds::reserve(vk::Uploader& uploader, const scene::Scene& scene, const WorldStates& worlds,
                        const Poses& poses, const WorldDeformer& deformed) {
  const WorldInputs& inputs = *worlds.inputs;
  std::vector<uint32_t> choices = choicesOf(worlds, scene);
  const auto instances = static_cast<uint32_t>(scene.instances.size());
  const bool derives = inputs.hasFactors();
  if (!onDevice_ || count_ != worlds.count || instances_ != instances || choices_ != choices ||
      palette_ != inputs.palette || derivesMaterials_ != derives || deformedMeshes_ != deformed.meshes()) {
    ++revision_;
    deformedMeshes_ = deformed.meshes();
    derivesMaterials_ = derives;
    onDevice_ = false;  // until the uploads have succeeded, so that a call after a failure repeats them
    choices_ = std::move(choices);
    palette_ = inputs.palette;
    if (!choices_.empty()) choiceList_.upload(uploader, choices_);
    if (!palette_.empty()) paletteList_.upload(uploader, palette_);
  }
  onDevice_ = true;
  count_ = worlds.count;
  instances_ = instances;
  records_.clear();
  bounds_.clear();
  worldBounds_.clear();
  vast_ = vastOnDevice_;
  moves_ = !poses.current.empty() || inputs.previous.address != 0 || inputs.next.address != 0;
  list_.resize(size_t{count_} * instances_);
  if (moves_) previous_.resize(size_t{count_} * instances_);
  if (moves_) next_.resize(size_t{count_} * instances_);
}

void GpuWorlds::update(vk::Uploader& uploader, const scene::Scene& scene, const GpuInstances& instances,
                       const WorldStates& worlds, const Poses& poses, const Deformer* deformer,
                       const WorldDeformer& deformed) {
  hasMaterials_ = !worlds.materials.empty() || !worlds.factors.empty() ||
                  (worlds.inputs && (worlds.inputs->hasFactors() || !worlds.inputs->palette.empty()));
  variesExistence_ = !worlds.exists.empty() || (worlds.inputs && worlds.inputs->exists != 0);
  listed_ = worlds.instances;
  emissiveOnDevice_ = worlds.inputs && worlds.inputs->emissive.address != 0;
  hasOnDevice_ = 0;
  if (worlds.inputs && worlds.inputs->environmentIntensity.address) hasOnDevice_ |= shared::kWorldHasIntensity;
  if (worlds.inputs && worlds.inputs->environmentRotation.address) hasOnDevice_ |= shared::kWorldHasRotation;
  if (worlds.inputs && worlds.inputs->hasLights()) hasOnDevice_ |= shared::kWorldHasLights;
  rotations_ = worlds.environmentRotation;
  intensities_ = worlds.environmentIntensity;
  environmentIndex_ = worlds.environmentIndex;
  if (worlds.inputs && worlds.inputs->environmentIndex.address) hasOnDevice_ |= shared::kWorldHasEnvironment;
  if (worlds.inputs) return reserve(uploader, scene, worlds, poses, deformed);
  onDevice_ = false;
  const std::vector<glm::dmat4> transforms = scene::instanceTransforms(scene, poses.current);
  count_ = worlds.count;
  instances_ = static_cast<uint32_t>(transforms.size());
  records_.resize(size_t{count_} * instances_);
  bounds_.resize(records_.size());
  worldBounds_.assign(count_, {});
  // Bounds are those of GpuScene::bounds(), at rest or in a pose.
  const bool atRest = poses.current.empty() && !deformed.posesJoints();
  const auto extend = [&](scene::Bounds& all, uint32_t i, const scene::ReachBox& box, const glm::dmat4& toWorld,
                          const WorldSphere& sphere) {
    if (sphere.radius < 0) return;
    if (!atRest)
      include(all, sphere);
    else if (!scene.meshes[scene.instances[i].mesh].positions.empty())
      scene::addBox(box.low, box.high, toWorld, all);
  };
  const auto place = [&](uint32_t world) {
    const WorldState state = stateOf(worlds, world, scene, transforms);
    const bool empty = !worlds.empty.empty() && worlds.empty[world];
    std::vector<WorldDeformer::HostBounds> shapes;
    if (!deformed.empty() && !empty) shapes = deformed.boundsIn(world, scene, worlds.deformations, poses);
    for (uint32_t i = 0; i < instances_; ++i) {
      const glm::dmat4& toWorld = state.transforms[i];
      PosedBounds bounds = instances.boundsIn(i, poses.current, deformer);
      std::optional<float> longestEdge;
      const uint32_t place = deformed.placeOf(scene.instances[i].mesh);
      const bool deforms = place != shared::kNowhere && !empty;
      if (deforms) {
        bounds.box = shapes[place].box;
        bounds.turnedOver = shapes[place].turnedOver;
        longestEdge = shapes[place].longestEdge;
      }
      WorldSphere sphere = instances.sphereOf(bounds, toWorld);
      if (!state.exists[i]) sphere.radius = WorldSphere{}.radius;
      shared::Instance& record = records_[size_t{world} * instances_ + i];
      record = instances.recordOf(i, toWorld, sphere.turnedOver, longestEdge);
      if (deforms) record.mesh = deformed.firstMesh() + world * deformed.meshCount() + place;
      record.material = state.materials[i];
      if (sphere.radius < 0) record.flags |= shared::kInstanceAbsent;
      bounds_[size_t{world} * instances_ + i] = instances.onDevice(sphere);
      extend(worldBounds_[world], i, bounds.box, toWorld, sphere);
    }
  };
  parallelFor(count_, worldsPerTask(instances_), [&](size_t begin, size_t end) {
    for (size_t world = begin; world < end; ++world) place(static_cast<uint32_t>(world));
  });
  vast_ = std::ranges::any_of(
      records_, [](const shared::Instance& record) { return (record.flags & shared::kInstanceVast) != 0; });
  list_.upload(uploader, records_);
  moves_ = !poses.current.empty() || !worlds.previous.empty() || !worlds.next.empty();
  if (moves_) {
    uploadMoved(previous_, uploader, scene, instances, worlds, worlds.previous, poses.previous);
    uploadMoved(next_, uploader, scene, instances, worlds, worlds.next, poses.next);
  }
  ++revision_;
}

// Uploads the instances with the transforms of another frame.
void GpuWorlds::uploadMoved(GpuList<shared::Instance>& list, vk::Uploader& uploader, const scene::Scene& scene,
                            const GpuInstances& instances, const WorldStates& worlds,
                            const std::vector<glm::dmat4>& transforms, const scene::Pose& pose) const {
  const std::vector<glm::dmat4> scenes = scene::instanceTransforms(scene, pose);
  const std::vector<glm::dmat4>& values = transforms.empty() ? worlds.transforms : transforms;
  std::vector<shared::Instance> moved = records_;
  parallelFor(count_, worldsPerTask(instances_), [&](size_t begin, size_t end) {
    for (size_t world = begin; world < end; ++world) {
      std::vector<glm::dmat4> there = scenes;
      moveTo(there, worlds, values, static_cast<uint32_t>(world));
      for (uint32_t i = 0; i < instances_; ++i) instances.move(moved[world * instances_ + i], i, there[i]);
    }
  });
  list.upload(uploader, moved);
}

namespace {

shared::LightTemplate lightTemplateOf(const scene::Light& atRest, const scene::Light& posed, const glm::dvec3& origin) {
  shared::LightTemplate t{.color = atRest.color, .intensity = atRest.intensity, .listed = ~0u, .mapCaster = ~0u};
  if (atRest.node >= 0) t.state |= shared::kLightHasNode;
  if (!shared::lightIsArea(atRest.type)) {
    t.light[0] = deviceLight(atRest, origin);
    t.light[1] = deviceLight(posed, origin);
    t.radiusClass = shared::lightIsDirectional(atRest.type) ? 0 : radiusClass(t.light[0].radius);
    return t;
  }
  scene::Light shape = atRest;
  shape.color = glm::vec3(1);
  shape.intensity = 1;
  t.area[0] = deviceAreaLight(shape, origin);
  shape.position = posed.position;
  shape.axes = posed.axes;
  t.area[1] = deviceAreaLight(shape, origin);
  t.state |= shared::kLightIsArea;
  if (shared::maxChannel(t.area[0].radiance) > 0) t.state |= shared::kLightHasExtent;
  return t;
}

}  // namespace

// Lists the lights from which shaders write those of each world. Lights that the worlds do not describe are the same
// at rest and posed.
void GpuWorlds::reserveLights(const WorldStates& worlds, const std::vector<scene::Light>& lights,
                              const scene::Scene& scene, const glm::dvec3& origin) {
  const glm::dmat4 fileFromWorld = scene::fileFromWorld(scene);
  std::vector<uint32_t> listed(lights.size(), ~0u);
  for (uint32_t i = 0; i < worlds.lights.size(); ++i) listed[worlds.lights[i]] = i;
  for (size_t i = 0; i < lights.size(); ++i) {
    if (lights[i].removed) continue;
    const bool own = listed[i] != ~0u;
    const scene::Light& atRest = own ? worlds.inputs->lights[listed[i]] : lights[i];
    scene::Light posed = atRest;
    if (posed.node >= 0)
      posed.position = lights[i].position, posed.direction = lights[i].direction, posed.axes = lights[i].axes;
    shared::LightTemplate& t = placed_.templates.emplace_back(lightTemplateOf(atRest, posed, origin));
    placed_.authored.push_back(atRest);
    t.listed = listed[i];
    t.fileDirection = glm::vec3(fileFromWorld * glm::dvec4(atRest.direction, 0));
    const glm::dvec3 inFile = fileFromWorld * glm::dvec4(atRest.position, 1);
    for (const glm::dvec3& position : {atRest.position, posed.position, inFile})
      for (int axis = 0; axis < 3; ++axis) placed_.positions.push_back(position[axis]);
    const bool area = (t.state & shared::kLightIsArea) != 0, everywhere = shared::lightIsDirectional(atRest.type);
    placed_.area += area;
    placed_.directional += everywhere;
    placed_.local += !area && !everywhere;
    placed_.unbounded += !area && !everywhere && !atRest.range;
  }
  lightStride_ = areaStride_ = placed_.templates.size();
  treeStride_ = shared::kPlacedLightBoxes;
  lightList_.resize(count_ * lightStride_);
  lightTrees_.resize(count_ * treeStride_);
  areaLights_.resize(count_ * areaStride_);
  placed_.lights = lightList_.address();
  placed_.boxes = lightTrees_.address();
  placed_.areaLights = areaLights_.address();
}

void GpuWorlds::castRays(std::span<const shared::RayShadow> rays) {
  for (size_t i = 0; i < rays.size(); ++i) {
    if (rays[i].light == shared::kRayNone) continue;
    shared::LightTemplate& t = placed_.templates[i];
    t.state |= shared::kLightCastsByRays;
    t.shadowRays = rays[i].rays;
    t.shadowSize = rays[i].lightSize;
    placed_.mostRays = std::max(placed_.mostRays, rays[i].rays);
    ++placed_.casters;
  }
  if (placed_.casters == 0) return;
  otherLights_.resize(count_ * lightStride_);
  rayShadows_.resize(size_t{count_} * placed_.casters);
  placed_.others = otherLights_.address();
  placed_.rayShadows = rayShadows_.address();
}

void GpuWorlds::castMaps(std::span<const uint32_t> templates) {
  for (uint32_t i = 0; i < templates.size(); ++i) placed_.templates[templates[i]].mapCaster = i;
  placed_.mapCasters = static_cast<uint32_t>(templates.size());
  if (templates.empty()) return;
  placedCasters_.resize(size_t{count_} * placed_.mapCasters);
  shadowBits_.resize(count_ * placed_.shadowBitsBytes() / sizeof(shared::ShadowBits));
  placed_.placedCasters = placedCasters_.address();
  placed_.shadowBits = shadowBits_.address();
}

// Every world has the space of the largest one, so that shaders may load a light whose index is valid in another world.
void GpuWorlds::updateLights(vk::Uploader& uploader, const WorldStates& worlds, const std::vector<scene::Light>& lights,
                             const scene::Scene& scene, const glm::dvec3& origin) {
  lights_.clear();
  placed_ = {};
  if (worlds.inputs && worlds.inputs->hasLights()) return reserveLights(worlds, lights, scene, origin);
  if (worlds.lightValues.empty()) return;
  lights_.resize(count_);
  const size_t listed = worlds.lights.size();
  parallelFor(count_, kLightSetsPerTask, [&](size_t begin, size_t end) {
    for (size_t world = begin; world < end; ++world) {
      std::vector<scene::Light> own = lights;
      for (size_t i = 0; i < listed; ++i) {
        scene::Light& light = own[worlds.lights[i]];
        scene::Light value = worlds.lightValues[world * listed + i];
        value.removed = light.removed;
        if (value.node >= 0)
          value.position = light.position, value.direction = light.direction, value.axes = light.axes;
        light = std::move(value);
      }
      lights_[world] = makeLightSet(std::move(own), origin);
    }
  });
  lightStride_ = treeStride_ = areaStride_ = 1;
  for (const LightSet& set : lights_) {
    areaStride_ = std::max(areaStride_, set.area.size());
    lightStride_ = std::max(lightStride_, set.lights.size());
    treeStride_ = std::max(treeStride_, set.nodes.size());
  }
  std::vector<shared::Light> all(count_ * lightStride_);
  std::vector<shared::LightBox> nodes(count_ * treeStride_);
  std::vector<shared::AreaLight> area(count_ * areaStride_);
  for (size_t world = 0; world < count_; ++world) {
    std::ranges::copy(lights_[world].lights, all.begin() + static_cast<std::ptrdiff_t>(world * lightStride_));
    std::ranges::copy(lights_[world].nodes, nodes.begin() + static_cast<std::ptrdiff_t>(world * treeStride_));
    std::ranges::copy(lights_[world].area, area.begin() + static_cast<std::ptrdiff_t>(world * areaStride_));
  }
  lightList_.upload(uploader, all);
  lightTrees_.upload(uploader, nodes);
  areaLights_.upload(uploader, area);
}

float GpuWorlds::environmentRotation(uint32_t world, float others) const {
  return count_ > 0 && !rotations_.empty() ? rotations_[world] : others;
}

float GpuWorlds::environmentIntensity(uint32_t world, float others) const {
  return count_ > 0 && !intensities_.empty() ? intensities_[world] : others;
}

void GpuWorlds::setEnvironments(vk::Uploader& uploader, std::vector<uint32_t> maps) {
  uploadChanged(environmentList_, environmentMaps_, std::move(maps), uploader);
}

uint32_t GpuWorlds::environmentMap(uint32_t world) const {
  if (!hasEnvironments()) return 0;
  return environmentMaps_[environmentIndex_.empty() ? 0 : environmentIndex_[world]];
}

void GpuWorlds::describeLights(shared::FrameConstants& frame, uint32_t world) const {
  frame.lights = lightList_.address() + world * lightStride_ * sizeof(shared::Light);
  frame.lightTree = lightTrees_.address() + world * treeStride_ * sizeof(shared::LightBox);
  frame.areaLights = areaLights_.address() + world * areaStride_ * sizeof(shared::AreaLight);
  if (hasLights()) lights_[world].describe(frame);
}

void GpuWorlds::updateValues(vk::Uploader& uploader) {
  if (!onDevice()) return;
  if (hasOnDevice_) valueList_.resize(count_);
  if (lights_.empty() && rotations_.empty() && intensities_.empty() && environmentIndex_.empty()) {
    if (hasOnDevice_) values_.clear();  // shaders overwrite them
    return;
  }
  std::vector<shared::WorldValues> values(count_);
  for (uint32_t world = 0; world < count_; ++world) {
    shared::WorldValues& value = values[world];
    if (!lights_.empty()) {
      shared::FrameConstants frame{};
      lights_[world].describe(frame);
      value = {frame.lightCount, frame.directionalLights, frame.lightTreeLeaves, frame.areaLightCount, 0, 0, 0, 0};
    }
    if (!intensities_.empty()) value.environmentIntensity = intensities_[world];
    value.environmentMap = environmentMap(world);
    if (rotations_.empty()) continue;
    value.environmentCos = std::cos(rotations_[world]);
    value.environmentSin = std::sin(rotations_[world]);
  }
  const size_t bytes = values.size() * sizeof(shared::WorldValues);
  // Shaders may have overwritten values that a later call gives as a list.
  const bool same = valuesOnDevice_ == hasOnDevice_ && values.size() == values_.size();
  valuesOnDevice_ = hasOnDevice_;
  if (same && std::memcmp(values.data(), values_.data(), bytes) == 0) return;
  values_.clear();  // until the upload has succeeded
  valueList_.upload(uploader, values);
  values_ = std::move(values);
}

void GpuWorlds::describe(shared::ViewConstants& constants) const {
  constants.values = valueList_.address();
  constants.instanceStride = uint64_t{instances_} * sizeof(shared::Instance);
  constants.lightStride = lightStride_ * sizeof(shared::Light);
  constants.treeStride = treeStride_ * sizeof(shared::LightBox);
  constants.areaStride = areaStride_ * sizeof(shared::AreaLight);
  if (hasLights()) constants.has |= shared::kWorldHasLights;
  if (!intensities_.empty()) constants.has |= shared::kWorldHasIntensity;
  if (!rotations_.empty()) constants.has |= shared::kWorldHasRotation;
  if (!environmentIndex_.empty()) constants.has |= shared::kWorldHasEnvironment;
  constants.has |= hasOnDevice_;
}

InstancesOfWorld GpuWorlds::of(uint32_t world) const {
  const size_t first = size_t{world} * instances_;
  return {std::span(records_).subspan(first, instances_), std::span(bounds_).subspan(first, instances_),
          list_.address() + first * sizeof(shared::Instance)};
}

void GpuWorlds::describe(shared::FrameConstants& frame, uint32_t world) const {
  const uint64_t offset = uint64_t{world} * instances_ * sizeof(shared::Instance);
  frame.instances = list_.address() + offset;
  frame.previousInstances = moves_ ? previous_.address() + offset : frame.instances;
  frame.nextInstances = moves_ ? next_.address() + offset : frame.instances;
}

}  // namespace latelight::render
