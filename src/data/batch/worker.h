// Renders the frames of a work list on one device.
#pragma once

#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "data/batch/scene_loader.h"
#include "data/batch/work.h"
#include "data/batch/writers.h"
#include "render/submit/renderer.h"

namespace latelight::data {

class Worker {
 public:
  Worker(const Job& job, const Plan& plan, SceneLoader& loader, WorkList& work, Writers& writers, ShardLog& log,
         const vk::DeviceOptions& device);

  // Renders until no work remains or a signal requests a stop. Failures of frames and scenes are recorded, and the
  // other frames are still rendered. If the device is lost, rendering continues on a new one. Throws Error(Internal)
  // for validation messages, and Error(DeviceLost) if the device is lost repeatedly.
  void run();

 private:
  struct InFlight {
    Chunk chunk;
    render::Ticket ticket;
    std::vector<RenderedFrame> frames;
  };

  bool loadNext();
  void start(Chunk chunk);
  void finishOldest();
  void finishAll();
  void finish(RenderedFrame frame, output::FrameOutput picture);
  void renderIsolated(const Chunk& chunk);
  vk::Device& device() { return devices_.back(); }
  void useDevice();
  void replaceLostDevice();
  render::Ticket submit(const Chunk& chunk);
  void useEnvironment();
  RenderedFrame frameOf(uint64_t index, const Chunk& chunk, const output::Metadata& shared);
  std::vector<RenderedFrame> framesOf(const Chunk& chunk);
  void addExtras(const Chunk& chunk, std::vector<RenderedFrame>& frames);
  void addScans(const render::Settings& settings, DataFrame& frame);
  void addPairs(const render::Settings& settings, const scene::Pose& pose, DataFrame& frame);
  const scene::Camera& cameraOf(uint64_t index) const;
  uint64_t noiseSeedOf(uint64_t index) const;
  render::SceneState momentOf(const Chunk& chunk) const;
  void addNeighbors(uint64_t index, render::SceneState& moment) const;
  std::vector<output::CameraMetadata> edgesOf(uint64_t index, const render::Settings& settings) const;
  render::Settings settingsOf(const Chunk& chunk);
  void fail(const Chunk& chunk, const std::string& why);

  const Job& job_;
  const Plan& plan_;
  SceneLoader& loader_;
  WorkList& work_;
  Writers& writers_;
  ShardLog& log_;
  const vk::DeviceOptions deviceOptions_;
  std::deque<vk::Device> devices_;  // the last one is in use, the others were lost

  std::optional<uint32_t> sceneIndex_, nextIndex_;
  std::future<std::unique_ptr<LoadedScene>> next_;
  std::unique_ptr<LoadedScene> scene_;
  GeometryHashes geometry_;  // for scene_
  std::string environment_;
  std::unique_ptr<render::Renderer> renderer_;  // for scene_ in environment_
  std::deque<InFlight> inFlight_;
};

}  // namespace latelight::data
