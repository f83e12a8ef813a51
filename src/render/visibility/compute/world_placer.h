// Places worlds on the device: converts the arrays of a call (WorldInputs) to the records of instances and views that
// the raster compute and the passes after it read. The host's work does not depend on the number of worlds.
//
//   WorldInputs   check_worlds.comp     status (kWorld* per world)
//        |        (WorldDeformer)       meshes that worlds deform, and their bounds
//        |        place_instances.comp  Instance[worlds][instances] at each time, RasterInstance[worlds][draws],
//        |                              Material[worlds][listed instances] with the factors of worlds
//        |        place_lights.comp     Light[worlds][lights] and their trees, AreaLight[worlds][lights], WorldValues
//        |        world_bounds.comp     bounds of worlds, if shadow maps are fitted to them
//        +------> place_views.comp      View[worlds][cameras] at each time, WorldValues[worlds] of the environment
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/visibility/compute/place_worlds_push.h"
#include "render/visibility/compute/raster_instances.h"

namespace latelight::render {

// The validity of each world of a call, as kWorld* bits. The device writes it before it renders the first view.
class WorldStatus {
 public:
  WorldStatus(vk::Device& device, size_t worlds);
  std::span<const uint32_t> bits() const { return {buffer_.as<uint32_t>(), worlds_}; }  // after the first views
  const vk::Buffer& buffer() const { return buffer_; }

 private:
  size_t worlds_;
  vk::Buffer buffer_;
};

class WorldPlacer {
 public:
  explicit WorldPlacer(vk::Device& device);
  static bool runsOn(const vk::Device& device);  // it requires doubles in shaders

  // Prepares the conversion. `scene`, `raster` and `worlds` belong to the same call: all of them are up to date. The
  // conversion is pending until the next graph. `bounds`: also computes the worlds' bounds, at rest.
  void update(const scene::Scene& source, const GpuScene& scene, const RasterInstances& raster,
              const WorldStates& worlds, const Poses& poses, vk::Uploader& uploader, uint32_t width, uint32_t height,
              bool bounds);
  // The same for worlds that differ in arrays only (differInArraysOnly()) from those of the last update(), which may be
  // in flight.
  void updateArrays(const WorldStates& worlds);
  // A conversion, to repeat after others that only updateArrays() has prepared since.
  struct Conversion {
    shared::WorldJob job;
    std::shared_ptr<WorldStatus> status;
  };
  Conversion conversion() const { return {job_, status_}; }  // of the last update or updateArrays()
  // Returns true if it was the last one.
  bool isLatest(const Conversion& conversion) const { return conversion.status == status_; }
  void repeat(const Conversion& conversion);
  // Adds the pending conversion to the prologue of a graph, after the scene's changes.
  void addChanges(graph::Graph& graph) const;
  void changesSubmitted() { pending_ = false; }
  // Drops a pending conversion of a call that failed: the arrays and lists that it refers to may no longer exist.
  void discardChanges() { pending_ = false; }

  // The bounds of each world at rest, double[worlds][6], if update() was asked for them.
  VkDeviceAddress bounds() const { return job_.bounds; }
  // The address of the first view of a world at a time (0 current, 1 previous, 2 next frame), View[].
  VkDeviceAddress views(uint32_t world, uint32_t time) const;

 private:
  void describeInstances(const scene::Scene& source, const GpuScene& scene, const RasterInstances& raster,
                         const WorldStates& worlds, const Poses& poses, vk::Uploader& uploader);
  void describeMaterials(const scene::Scene& source, const GpuScene& scene, const WorldInputs& inputs,
                         vk::Uploader& uploader);
  void describeLights(const GpuScene& scene, const WorldStates& worlds, vk::Uploader& uploader);
  void describeCameras(const GpuScene& scene, const WorldStates& worlds, vk::Uploader& uploader);
  void takeArrays(const WorldInputs& inputs);
  void takeStatus(size_t worlds);
  void dispatch(graph::Graph& graph, const vk::PipelineRef& pipeline, uint64_t elements, uint32_t times) const;

  vk::Device& device_;
  struct Pipelines {
    vk::PipelineRef check, instances, bounds, lights, views;
  };
  std::optional<Pipelines> pipelines_;  // none before the first call
  shared::WorldJob job_{};
  const WorldDeformer* deformer_ = nullptr;  // of the scene
  bool pending_ = false;
  // The values that the last call uploaded; only those that differ are uploaded again.
  std::vector<shared::WorldTemplate> templateValues_;
  std::vector<double> numberValues_;  // matrices, transforms, poses of cameras
  std::vector<shared::View> viewValues_;
  std::vector<uint32_t> rideValues_, emptyValues_;
  GpuList<shared::WorldTemplate> templates_;
  GpuList<double> numbers_, bounds_;
  GpuList<shared::View> cameras_, views_[3];
  GpuList<uint32_t> rides_, empty_;
  std::vector<shared::DerivableMaterial> baseValues_;
  GpuList<shared::DerivableMaterial> bases_;
  std::vector<shared::LightTemplate> lightValues_;
  GpuList<shared::LightTemplate> lights_;
  std::vector<double> lightPositionValues_;
  GpuList<double> lightPositions_;
  vk::Buffer statusOnDevice_;
  std::vector<std::shared_ptr<WorldStatus>> statuses_;  // of calls in flight, and free ones
  std::shared_ptr<WorldStatus> status_;
};

}  // namespace latelight::render
