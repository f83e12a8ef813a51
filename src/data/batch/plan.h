// Every frame of a job: its index in the whole job, its name, and the hash of what makes it, whatever shard renders it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/memory.h"
#include "data/batch/job.h"
#include "data/batch/loaded_scene.h"

namespace latelight::data {

struct PlannedCamera {
  std::string name;
  uint64_t hash = 0;               // of all that it is, and where the job asks for motion, of its neighbors
  uint32_t width = 0, height = 0;  // pixels
  uint64_t moment = 0;             // CameraTimeline::momentOf()
};

struct PlannedScene {
  std::string source;
  std::vector<std::string> files;  // that it was read from
  uint64_t hash = 0;               // of their contents
  std::vector<PlannedCamera> cameras;
  uint64_t places = 0;  // frames that it has in the job's order: those of a broken scene are kept free
  std::string error;    // why it can't be loaded; empty: it can
};

// A frame by what it shows, each an index.
struct FramePlace {
  uint32_t scene = 0, variation = 0, camera = 0;
};

class Plan {
 public:
  // Loads each scene that the plan in `saved`, made by an earlier run, does not know, for its cameras. A broken scene
  // has an error, and as many places as the first good one has. Throws Error(Usage) where two frames have one name.
  Plan(const Job& job, const std::filesystem::path& saved);
  void save(const std::filesystem::path& path) const;

  uint64_t frames() const { return starts_.back(); }  // places in the order; those of broken scenes hold nothing
  const std::vector<PlannedScene>& scenes() const { return scenes_; }
  // Nothing for a place of a broken scene.
  std::optional<FramePlace> at(uint64_t index) const;
  std::string name(uint64_t index) const;
  // Of a frame with the same scene and variation, by its camera.
  std::string nameBeside(uint64_t index, size_t camera) const { return name(index - at(index)->camera + camera); }
  const PlannedCamera& camera(FramePlace place) const { return scenes_[place.scene].cameras[place.camera]; }
  // Of everything that the frame's files depend on, but for the device: frames with another hash are rendered again.
  uint64_t settings(uint64_t index) const;
  uint64_t hash() const;  // of all frames

  // Where there is only one scene, it need not be loaded again: null after the first call.
  std::unique_ptr<LoadedScene> takeScene() { return std::move(scene_); }

 private:
  bool findSaved(PlannedScene& scene, const nlohmann::ordered_json& saved) const;
  void look(PlannedScene& scene);
  void claimMemory(const PlannedScene& scene);
  void order();
  nlohmann::ordered_json describe() const;
  void checkNames() const;

  const Job& job_;
  uint64_t jobHash_ = 0;   // of what all frames depend on
  uint64_t loadHash_ = 0;  // of what the cameras of a scene depend on
  std::vector<PlannedScene> scenes_;
  std::vector<uint64_t> starts_;  // index of each scene's first frame, and behind the last
  std::unique_ptr<LoadedScene> scene_;
  MemoryClaim memory_;
};

}  // namespace latelight::data
