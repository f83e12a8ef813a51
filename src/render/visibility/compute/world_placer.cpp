#include "render/visibility/compute/world_placer.h"

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

#include "render/frame/view.h"
#include "scene/file_frame.h"
#include "vk/features.h"

namespace latelight::render {

namespace {

using namespace shared;  // kPlace*, kWorld*, kTemplate*

vk::PipelineRef placerPipeline(vk::Device& device, const char* shader, const char* name) {
  return device.cache().pipeline(vk::ComputeDesc{.shader = shader, .pushBytes = sizeof(PlacePush), .name = name});
}

void append(std::vector<double>& numbers, const glm::dmat4& matrix) {
  numbers.insert(numbers.end(), glm::value_ptr(matrix), glm::value_ptr(matrix) + 16);
}

WorldTemplate templateOf(const scene::Scene& source, const GpuScene& scene, uint32_t instance,
                         const scene::Pose& pose) {
  const Instance& record = scene.instances().record(instance);
  const scene::Mesh& mesh = source.meshes[record.mesh];
  const PosedBounds bounds = scene.boundsIn(instance, pose);
  constexpr uint32_t kGroup = ~0u << kInstanceGroupShift;
  return {.low = bounds.box.low,
          .high = bounds.box.high,
          .vertexOrigin = scene::vertexOrigin(mesh),
          .longestEdge = mesh.longestEdge,
          .mesh = record.mesh,
          .material = record.material,
          .id = record.id,
          .part = record.part,
          .flags = record.flags & (kInstanceExtras | kGroup),
          .place = kNowhere,
          .draw = kNowhere,
          .state = (bounds.shown ? 0u : kTemplateHidden) | (bounds.turnedOver ? kTemplateTurnedOver : 0u),
          .deformed = scene.worldDeformer().placeOf(record.mesh)};
}

WorldNumbers numbersOf(const WorldArray& array) {
  return {array.address, array.rows, array.element};
}

}  // namespace

WorldStatus::WorldStatus(vk::Device& device, size_t worlds)
    : worlds_(worlds),
      buffer_(device,
              {.size = worlds * sizeof(uint32_t), .kind = vk::MemoryKind::Readback, .name = "status of worlds, read"}) {
}

bool WorldPlacer::runsOn(const vk::Device& device) {
  return device.features().core.features.shaderFloat64;
}

WorldPlacer::WorldPlacer(vk::Device& device)
    : device_(device),
      templates_(device, "instances of worlds, common values"),
      numbers_(device, "matrices of worlds"),
      bounds_(device, "bounds of worlds"),
      cameras_(device, "cameras of worlds"),
      views_{GpuList<View>(device, "views of worlds"), GpuList<View>(device, "previous views of worlds"),
             GpuList<View>(device, "next views of worlds")},
      rides_(device, "rides of cameras"),
      empty_(device, "invalid worlds"),
      bases_(device, "materials to derive from"),
      lights_(device, "lights of worlds, common values"),
      lightPositions_(device, "positions of lights") {}

void WorldPlacer::update(const scene::Scene& source, const GpuScene& scene, const RasterInstances& raster,
                         const WorldStates& worlds, const Poses& poses, vk::Uploader& uploader, uint32_t width,
                         uint32_t height, bool bounds) {
  if (!pipelines_)
    pipelines_ = {placerPipeline(device_, "check_worlds.comp", "check worlds"),
                  placerPipeline(device_, "place_instances.comp", "place instances"),
                  placerPipeline(device_, "world_bounds.comp", "bounds of worlds"),
                  placerPipeline(device_, "place_lights.comp", "place lights"),
                  placerPipeline(device_, "place_views.comp", "place views")};
  const WorldInputs& inputs = *worlds.inputs;
  job_ = {};
  job_.worlds = worlds.count;
  job_.listed = static_cast<uint32_t>(worlds.instances.size());
  job_.width = width;
  job_.height = height;
  describeInstances(source, scene, raster, worlds, poses, uploader);
  describeCameras(scene, worlds, uploader);
  describeMaterials(source, scene, inputs, uploader);
  describeLights(scene, worlds, uploader);
  job_.environmentMaps = scene.worlds().environmentMapsAddress();
  job_.environments = static_cast<uint32_t>(worlds.environments.size());
  job_.values = scene.worlds().valuesAddress();
  deformer_ = &scene.worldDeformer();
  job_.deformed = deformer_->empty() ? 0 : deformer_->bounds();
  job_.deformedMeshes = deformer_->meshCount();
  job_.firstDeformed = deformer_->firstMesh();
  std::vector<uint32_t> empty(worlds.empty.begin(), worlds.empty.end());
  if (std::ranges::count(empty, 0u) == std::ssize(empty)) empty.clear();
  uploadChanged(empty_, emptyValues_, std::move(empty), uploader);
  job_.emptyWorlds = emptyValues_.empty() ? 0 : empty_.address();
  if (bounds) bounds_.resize(size_t{6} * worlds.count);
  job_.bounds = bounds ? bounds_.address() : 0;
  updateArrays(worlds);
}

void WorldPlacer::updateArrays(const WorldStates& worlds) {
  takeArrays(*worlds.inputs);
  takeStatus(worlds.count);
  pending_ = true;
}

void WorldPlacer::repeat(const Conversion& conversion) {
  job_ = conversion.job;
  status_ = conversion.status;
  pending_ = true;
}

void WorldPlacer::takeArrays(const WorldInputs& inputs) {
  const WorldArray* transforms[] = {&inputs.transforms, &inputs.previous, &inputs.next};
  const WorldArray* given[] = {&inputs.cameraToWorld, &inputs.previousCameraToWorld, &inputs.nextCameraToWorld};
  for (size_t time = 0; time < 3; ++time) {
    job_.givenTransforms[time] = numbersOf(*transforms[time]);
    job_.givenPoses[time] = numbersOf(*given[time]);
  }
  job_.intrinsics = numbersOf(inputs.intrinsics);
  job_.exists = inputs.exists;
  job_.materialChoice = numbersOf(inputs.materialChoice);
  job_.baseColor = numbersOf(inputs.baseColor);
  job_.metallic = numbersOf(inputs.metallic);
  job_.roughness = numbersOf(inputs.roughness);
  job_.emissive = numbersOf(inputs.emissive);
  job_.lightPosition = numbersOf(inputs.lightPosition);
  job_.lightDirection = numbersOf(inputs.lightDirection);
  job_.lightColor = numbersOf(inputs.lightColor);
  job_.lightIntensity = numbersOf(inputs.lightIntensity);
  job_.environmentRotation = numbersOf(inputs.environmentRotation);
  job_.environmentIntensity = numbersOf(inputs.environmentIntensity);
  job_.environmentIndex = numbersOf(inputs.environmentIndex);
}

void WorldPlacer::describeInstances(const scene::Scene& source, const GpuScene& scene, const RasterInstances& raster,
                                    const WorldStates& worlds, const Poses& poses, vk::Uploader& uploader) {
  const GpuWorlds& placed = scene.worlds();
  const GpuInstances& instances = scene.instances();
  const uint32_t count = instances.count();
  std::vector<WorldTemplate> templates;
  for (uint32_t i = 0; i < count; ++i) templates.push_back(templateOf(source, scene, i, poses.current));
  for (uint32_t i = 0; i < worlds.instances.size(); ++i) templates[worlds.instances[i]].place = i;
  for (uint32_t draw = 0; draw < raster.records().size(); ++draw)
    templates[raster.records()[draw].instance].draw = draw;
  std::vector<double> numbers;
  append(numbers, scene::worldFromFile(source));
  append(numbers, glm::inverse(scene::worldFromFile(source)));
  append(numbers, glm::transpose(viewFromOpenCv()));
  glm::dmat4 origin(0);
  origin[0] = glm::dvec4(scene.origin(), 0);
  append(numbers, origin);
  const scene::Pose* all[] = {&poses.current, &poses.previous, &poses.next};
  for (uint32_t time = 0; time < placed.instanceTimes(); ++time)
    for (const glm::dmat4& transform : scene::instanceTransforms(source, *all[time])) append(numbers, transform);
  for (const scene::Camera& camera : worlds.inputs->cameras) append(numbers, camera.toWorld);
  uploadChanged(templates_, templateValues_, std::move(templates), uploader);
  uploadChanged(numbers_, numberValues_, std::move(numbers), uploader);
  constexpr uint64_t kMatrix = 16 * sizeof(double);
  job_.templates = templates_.address();
  job_.matrices = numbers_.address();
  job_.transforms = job_.matrices + kWorldMatrices * kMatrix;
  job_.cameraPoses = job_.transforms + uint64_t{count} * placed.instanceTimes() * kMatrix;
  job_.instanceCount = count;
  job_.instanceTimes = placed.instanceTimes();
  for (uint32_t time = 0; time < job_.instanceTimes; ++time) job_.instances[time] = placed.listAt(time);
  job_.choices = placed.choicesAddress();
  job_.palette = placed.paletteAddress();
  job_.paletteSize = static_cast<uint32_t>(worlds.inputs->palette.size());
  job_.materials = scene.materials().address();
  job_.draws = static_cast<uint32_t>(raster.records().size());
  job_.rasterTemplates = raster.templates();
  job_.raster = job_.draws > 0 ? raster.address(0) : 0;
}

void WorldPlacer::describeMaterials(const scene::Scene& source, const GpuScene& scene, const WorldInputs& inputs,
                                    vk::Uploader& uploader) {
  job_.firstDerived = kNowhere;
  if (!inputs.hasFactors()) return;
  job_.firstDerived = static_cast<uint32_t>(source.materials.size());
  std::vector<DerivableMaterial> bases;
  for (uint32_t i = 0; i < source.materials.size(); ++i) {
    const GpuMaterials::Derivable base = scene.materials().derivable(i);
    bases.push_back({base.flags, base.opaqueTextures ? 1u : 0u});
  }
  uploadChanged(bases_, baseValues_, std::move(bases), uploader);
  job_.bases = bases_.address();
}

void WorldPlacer::describeLights(const GpuScene& scene, const WorldStates& worlds, vk::Uploader& uploader) {
  if (!scene.worlds().placesLights()) return;
  const GpuWorlds::PlacedLights& placed = scene.worlds().placedLights();
  uploadChanged(lights_, lightValues_, std::vector(placed.templates), uploader);
  uploadChanged(lightPositions_, lightPositionValues_, std::vector(placed.positions), uploader);
  job_.lights = static_cast<uint32_t>(placed.templates.size());
  job_.listedLights = static_cast<uint32_t>(worlds.lights.size());
  job_.lightTemplates = lights_.address();
  job_.lightPositions = lightPositions_.address();
  job_.lightList = placed.lights;
  job_.lightBoxes = placed.boxes;
  job_.areaLights = placed.areaLights;
  job_.otherLights = placed.others;
  job_.rayShadows = placed.rayShadows;
  job_.casters = placed.casters;
  job_.placedCasters = placed.placedCasters;
  job_.shadowBits = placed.shadowBits;
  job_.mapCasters = placed.mapCasters;
}

void WorldPlacer::describeCameras(const GpuScene& scene, const WorldStates& worlds, vk::Uploader& uploader) {
  const WorldInputs& inputs = *worlds.inputs;
  const size_t count = inputs.cameras.size();
  std::vector<View> views;
  for (const scene::Camera& camera : inputs.cameras)
    views.push_back(makeView(camera, job_.width, job_.height, glm::vec2(0), scene.origin()));
  uploadChanged(cameras_, viewValues_, std::move(views), uploader);
  uploadChanged(rides_, rideValues_, std::vector(inputs.rides), uploader);
  const bool moves = !inputs.rides.empty() || inputs.previousCameraToWorld.address || inputs.nextCameraToWorld.address;
  job_.cameras = cameras_.address();
  job_.rides = inputs.rides.empty() ? 0 : rides_.address();
  job_.viewsPerWorld = static_cast<uint32_t>(count);
  job_.viewTimes = moves ? 3 : 1;
  for (uint32_t time = 0; time < job_.viewTimes; ++time) {
    views_[time].resize(worlds.count * count);
    job_.views[time] = views_[time].address();
  }
}

// Reuses the memory of a call that has finished.
void WorldPlacer::takeStatus(size_t worlds) {
  if (statusOnDevice_.size() < worlds * sizeof(uint32_t))
    statusOnDevice_ = vk::Buffer(device_, {.size = worlds * sizeof(uint32_t), .name = "status of worlds"});
  status_ = nullptr;
  std::erase_if(statuses_, [&](const auto& status) {
    return status.use_count() == 1 && status->bits().size() != worlds;  // deletion waits for the device
  });
  for (const auto& status : statuses_)
    if (status.use_count() == 1) status_ = status;
  if (!status_) status_ = statuses_.emplace_back(std::make_shared<WorldStatus>(device_, worlds));
  job_.status = statusOnDevice_.address();
}

VkDeviceAddress WorldPlacer::views(uint32_t world, uint32_t time) const {
  return job_.views[time < job_.viewTimes ? time : 0] + uint64_t{world} * job_.viewsPerWorld * sizeof(View);
}

void WorldPlacer::dispatch(graph::Graph& graph, const vk::PipelineRef& pipeline, uint64_t elements,
                           uint32_t times) const {
  const VkDeviceAddress job = graph.constants(std::as_bytes(std::span(&job_, 1)));
  graph.prologue(graph::Stage::Upload, "place worlds", [=](graph::Context& context) {
    context.commands().bind(pipeline.get(), {}, PlacePush{job});
    dispatchElements(context.get(), elements, times);
  });
}

void WorldPlacer::addChanges(graph::Graph& graph) const {
  if (!pending_) return;
  const uint64_t worlds = job_.worlds;
  graph.prologue(graph::Stage::Upload, "place worlds", [this, worlds](graph::Context& context) {
    vkCmdFillBuffer(context.get(), statusOnDevice_.get(), 0, worlds * sizeof(uint32_t), 0);
  });
  dispatch(graph, pipelines_->check, worlds * std::max({job_.listed, job_.viewsPerWorld, job_.listedLights, 1u}), 1);
  if (!deformer_->empty()) deformer_->addTo(graph, statusOnDevice_.address());
  if (job_.instanceCount > 0) dispatch(graph, pipelines_->instances, worlds * job_.instanceCount, 1);
  if (job_.bounds) dispatch(graph, pipelines_->bounds, worlds * kPlaceGroup, 1);
  if (job_.lights > 0) dispatch(graph, pipelines_->lights, worlds * kPlaceGroup, 1);
  dispatch(graph, pipelines_->views, worlds * job_.viewsPerWorld, job_.viewTimes);
  graph.prologue(graph::Stage::Upload, "place worlds", [this, status = status_, worlds](graph::Context& context) {
    const VkBufferCopy copy{0, 0, worlds * sizeof(uint32_t)};
    vkCmdCopyBuffer(context.get(), statusOnDevice_.get(), status->buffer().get(), 1, &copy);
    vk::recordMemoryBarrier(context.get(), VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                            VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  });
}

}  // namespace latelight::render
