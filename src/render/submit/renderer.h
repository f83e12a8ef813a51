// Renders pictures of one scene on one device, any number of times.
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "graph/graph.h"
#include "render/exposure/camera_samples.h"
#include "render/gpu_scene/gpu_environment.h"
#include "render/gpu_scene/gpu_scene.h"
#include "render/lens/lens_rays.h"
#include "render/lighting/reference/indirect_filter.h"
#include "render/post/taa/taa.h"
#include "render/rays/environment_cells.h"
#include "render/rays/scene_bvh.h"
#include "render/settings/settings.h"
#include "render/submit/cast.h"
#include "render/submit/replay.h"
#include "render/submit/scene_state.h"
#include "render/submit/strips.h"
#include "render/submit/ticket.h"
#include "render/submit/view_set.h"
#include "render/visibility/compute/world_placer.h"
#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::render {

struct ViewBatch;

// Returns the light of --sun, or nothing without it.
std::optional<scene::Light> sunOf(const Settings& settings);

class Renderer {
 public:
  // `environment` may be null. The scene must outlive the renderer.
  Renderer(vk::Device& device, const scene::Scene& scene, const scene::Environment* environment);
  ~Renderer();

  // For long work of the host on results: calls the function of Device::whileWaiting() if it is due, as waits do.
  void checkWhileWaiting() { device_.wait(0); }

  // Starts one picture per camera, several at once, and returns while the device renders them. Meanwhile the scene may
  // be edited, and more pictures may be submitted. Throws Error(Usage) for invalid settings.
  // With Results::Exported, outputs are written to the memory of `targets`, if they have one there.
  Ticket submit(std::span<const scene::Camera> cameras, const Settings& settings, const SceneState& moment = {},
                Results results = Results::ToHost, const ExportTargets& targets = {});

  // Submits the pictures, waits for them, and returns only the frames.
  std::vector<output::FrameOutput> render(std::span<const scene::Camera> cameras, const Settings& settings,
                                          const SceneState& moment = {}) {
    return submit(cameras, settings, moment).take().frames;
  }

  // Renders only one of stripsOf(settings). Its rows are the same as in the full picture.
  RenderResult renderStrip(const scene::Camera& camera, const Settings& settings, Strip strip,
                           const SceneState& moment = {});

  // Returns the targets of the picture's own G-buffer, at pixel centers. Throws Error(Usage) if it has none.
  TargetsResult readTargets(const scene::Camera& camera, const Settings& settings, const SceneState& moment = {});

  // Throws the Error with which submit(), or readTargets() if `targets`, rejects a request that its scene, environment
  // or camera does not support. It needs no memory of the device, so options can be checked before they are used.
  // Limits of CPU devices, on numbers of lights and rays, are checked only when a picture is rendered.
  struct Request {
    const vk::Device& device;
    const scene::Scene& scene;
    bool hasEnvironment;
    const scene::Camera& camera;
    const Settings& settings;
    const SceneState& state;
  };
  static void check(const Request& request, bool targets);

  // Casts rays through the scene and waits for what they hit. Settings::dataSurfaces selects the surfaces; axes and
  // positionOrigin select the coordinate frames of rays and results. The first call builds the scene's BVHs, which
  // later calls update.
  CastResult cast(const CastRays& rays, const Settings& settings, const SceneState& moment = {});
  // The same with memory of the caller. `beforeStore` is called once, before the first hits are stored, if it is not
  // null.
  RenderStatistics cast(const CastRays& rays, const CastTargets& targets, const Settings& settings,
                        const SceneState& moment = {}, const std::function<void()>& beforeStore = {}) {
    return submitCast(rays, targets, settings, moment, beforeStore).take();
  }
  // Copies the rays and returns while the device casts them. The hits are stored in `targets` until the ticket is
  // taken. A limited number of rays is in flight, and the hits of earlier ones are stored before the call returns.
  CastTicket submitCast(const CastRays& rays, const CastTargets& targets, const Settings& settings,
                        const SceneState& moment = {}, std::function<void()> beforeStore = {});

  // Casts the rays of all worlds of `moment`, of which there is at least one, and returns while the device casts them.
  // The ticket holds all memory that the device reads, until it has finished.
  WorldCastTicket submitCast(WorldCast cast, const Settings& settings, const SceneState& moment);

  // Runs passes that trace rays through the scene (glsl/rays.glsl), and waits for them.
  graph::Submission traceRays(const AddRayPasses& add, const Settings& settings, const SceneState& moment = {});
  BvhStatistics bvhStatistics() const;
  BvhCosts bvhCosts() const { return bvh_ ? bvh_->costs() : BvhCosts{}; }

  // Returns true if shaders may place the worlds of a call with these settings and cameras (WorldStates::inputs). Other
  // calls require the host's records: those that draw, cast shadows of other lights than directional ones, or render a
  // picture in several parts.
  // `ownLights`: where the values of the worlds' lights are. `ownJoints`: worlds have joints of their own, to which
  // only the host fits shadow maps.
  enum class WorldLights : uint8_t { OfScene, InArrays, InLists };
  bool placesWorlds(const Settings& settings, std::span<const scene::Camera> cameras, const Poses& poses,
                    WorldLights ownLights, bool ownJoints) const;
  // Returns memory for WorldInputs that the host writes, at least `bytes`. It must be held until the call has finished.
  std::shared_ptr<const vk::Buffer> inputMemory(uint64_t bytes);

  const ClusterOcclusion& clusterOcclusion() const { return clusterOcclusion_; }
  const ShadowMapCache& shadowMaps() const { return shadowMaps_[1]; }  // of the raster compute

 private:
  friend class Ticket;
  bool foundVastWorlds(const ViewBatch& part);
  void discardChanges();
  void begin(const Settings& settings, const SceneState& moment);
  std::shared_ptr<RenderJob> start(std::span<const scene::Camera> cameras, const Settings& settings,
                                   const SceneState& moment, std::span<const Strip> strips,
                                   Results results = Results::ToHost, const ExportTargets& targets = {},
                                   std::vector<float> exposures = {});
  // Returns the exposure factor of each view, for settings with an automatic exposure (metering.cpp).
  std::vector<float> meter(std::span<const scene::Camera> cameras, const Settings& settings, const SceneState& moment);
  // Starts some views of a job, one strip after the other. Returns how many views fit into memory at once; if these are
  // fewer than `count`, none of them is in flight.
  size_t startViews(const std::shared_ptr<RenderJob>& job, size_t first, size_t count, std::span<const Strip> strips);
  struct Start {
    enum Outcome { Done, Overflowed, TooManyViews } outcome;
    uint64_t bytes = 0;  // with TooManyViews: the transient memory that the first graph needs
  };
  // `maxBytes`: limit on the transient memory of the first graph.
  Start startPart(ViewBatch& part, std::optional<uint64_t> maxBytes);
  Start build(ViewBatch& part, std::optional<uint64_t> maxBytes);
  // Return the replay of a batch, or nothing if its commands depend on more than their key, or if it was not recorded
  // (replay.cpp).
  std::optional<ReplayKey> replayKey(const ViewBatch& part) const;
  std::shared_ptr<Replay> replayOf(ViewBatch& part, const ReplayKey& key);
  std::shared_ptr<Replay> recordReplay(const ViewBatch& part);
  void submitChanges(ViewBatch& part);
  // The state of the scene and of the settings that begin() brings to the device.
  struct SceneInput {
    std::array<uint64_t, 5> edits;
    bool posed;  // or in several worlds
    std::optional<SunLight> sun;
    std::optional<uint32_t> anisotropy;
    bool inCompute;
    bool objectFrames, curvatures;  // outputs require them
    std::vector<uint32_t> groups;
    bool operator==(const SceneInput&) const = default;
  };
  // The state that the light of a scene at rest depends on. If it changes, the history of indirect light is no longer
  // valid.
  struct IndirectInput {
    std::array<uint64_t, 5> edits;
    const GpuEnvironment* environment;
    Settings settings;
    bool operator==(const IndirectInput&) const = default;
  };
  IndirectInput indirectInputOf(const Settings& settings) const;
  Histories historiesOf(const ViewBatch& part);
  void undoHistories(const Settings& settings);
  std::vector<uint32_t> selectEnvironments(const WorldStates& worlds);
  SceneInput inputOf(const Settings& settings, const SceneState& moment) const;
  bool differsInArraysOnly(const Settings& settings, const SceneState& moment) const;
  void placeAgain(const RenderJob& job);
  graph::Submission submit(const graph::Graph& graph, const graph::Plan& plan);
  void addSceneChanges(graph::Graph& graph) const;
  void followWorlds(const SceneState& moment);
  void findLowestPoint();
  shared::FrameConstants prepareRays(const Settings& settings, const SceneState& moment);  // for shaders without views
  std::vector<vk::Constant> rayConstants() const;
  void createBvh();  // without BVHs; before GpuScene::update(), so that pipelines compile while the scene is uploaded
  SceneBvh& followedBvh(bool samplesEnvironment);         // after GpuScene::update(): the BVHs of the same state
  void resolveOverflow(const ViewBatch* last = nullptr);  // of the batches up to this one; null: of all
  void read(RenderJob& job);                              // the oldest part
  void finish(RenderJob& job);

  ViewsInTime viewsOf(const ViewBatch& part, const CameraSample& sample);
  ViewsInTime placedViewsOf(const ViewBatch& part) const;
  std::vector<CameraSample> samplesOf(const ViewBatch& part) const;
  size_t viewsAtOnce(const RenderJob& job) const;
  void prepareScene(const Settings& settings);
  void poseScene(const RenderJob& job, size_t view, double seconds);
  void moveTo(ViewBatch& part, const CameraSample& sample, bool lit);
  FrameGraphBuilder& addRequest(ViewBatch& part, const CameraSample& sample);
  Start submitRequest(ViewBatch& part, std::optional<uint64_t> maxBytes);
  Start accumulate(ViewBatch& part, const CameraSample& sample, const vk::Image& sum, std::optional<uint64_t> maxBytes,
                   bool first);
  // The plans of shadows (shadows.cpp).
  bool placesShadows(const Settings& settings, const Poses& poses, WorldLights ownLights, bool ownJoints) const;
  void planPlacedShadows(const Settings& settings, const WorldStates& worlds);
  bool castsShadows(const Settings& settings) const;  // by maps that the host plans
  void listRays(const Settings& settings);
  ShadowPlan planPlacedRays(const Settings& settings) const;
  ShadowPlan planShadows(std::span<const scene::Camera> cameras, const Settings& settings) const;
  std::shared_ptr<FrameShadows> placeShadows(ShadowPlan plan, const Settings& settings);
  vk::Image makeSum(const ViewBatch& part);

  vk::Device& device_;
  const scene::Scene& scene_;
  GpuScene gpuScene_;
  GpuEnvironment environment_;
  bool hasEnvironment_;
  // The environments that worlds of earlier calls chose from. Null before the first such call.
  std::unique_ptr<GpuEnvironment> worldEnvironments_;
  std::vector<const scene::Environment*> worldEnvironmentSources_;  // one per layer
  DrawOrder drawOrder_;
  RasterInstances rasterInstances_;
  WorldPlacer worldPlacer_;
  std::vector<std::shared_ptr<const vk::Buffer>> inputMemory_;  // of calls in flight, and free ones
  ClusterOcclusion clusterOcclusion_;
  graph::Executor executor_;
  Overflow overflow_;
  std::unique_ptr<SceneBvh> bvh_;  // null before the first request for rays
  vk::Buffer environmentCells_;    // null before paths sample the environment
  vk::Buffer worldCells_;          // the same of worldEnvironments_
  double lowestPoint_ = 0;         // of the scene, as edited at `lowestPointEdits_`
  std::optional<std::array<uint64_t, 2>> lowestPointEdits_;
  PlacedShadowPlan placedShadows_;  // RenderState::placedShadows
  RenderState state_;
  FrameHistory history_ = temporalHistory(), indirectHistory_ = indirectHistory();
  std::optional<IndirectInput> indirectInput_;  // of the last frame of indirectHistory_
  LensRayCache lensRays_;
  std::shared_ptr<ExportPool> exports_ = std::make_shared<ExportPool>();
  ShadowMapCache shadowMaps_[2];              // of hardware and compute
  std::shared_ptr<FrameShadows> placedRays_;  // of the last worlds that shaders placed, or null
  std::optional<SceneInput> sceneInput_;      // of the last begin(), unless it failed
  // The rest of what the last begin() brought to the device, if shaders place worlds of a scene at rest.
  struct PlacedInput {
    Settings settings;
    WorldStates worlds;  // without memory: the addresses of its arrays may be invalid
  };
  std::optional<PlacedInput> placedInput_;
  ReplayCache replays_;
  // Batches in flight, in order. resolveOverflow() detects whether they overflowed, and renders them again, before
  // anything changes that they depend on.
  std::deque<std::shared_ptr<ViewBatch>> uncheckedBatches_;
};

}  // namespace latelight::render
