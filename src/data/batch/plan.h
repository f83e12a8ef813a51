// The plan of a job: the index, the name and a hash of all inputs of every frame. It is the same for all shards.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "base/memory.h"
#include "data/batch/job.h"
#include "data/batch/loaded_scene.h"

namespace latelight::data {

struct PlannedCamera {
  std::string name;
  uint64_t hash = 0;               // hash of the camera and, if the job outputs motion, of its neighbors
  uint32_t width = 0, height = 0;  // pixels
  uint64_t moment = 0;             // CameraTimeline::momentOf()
};

struct PlannedScene {
  std::string source;
  std::string name;                // the scene's own name, as the file states it
  std::vector<std::string> files;  // the files that the scene was read from
  uint64_t hash = 0;               // hash of the files' contents
  std::vector<PlannedCamera> cameras;
  std::vector<nlohmann::ordered_json> entries;  // Format::sceneEntry() of each of the job's formats
  uint64_t places = 0;                          // number of frame indices; those of a broken scene are reserved
  std::string error;                            // the reason that the scene cannot be loaded; empty: it can be loaded
};

// The scene, variation and camera of a frame, by index.
struct FrameLocation {
  uint32_t scene = 0, variation = 0, camera = 0;
};

// Returns the files that the job reads in addition to its scenes' own: of cameras, variations and the environment.
// Files that do not exist may be among them.
std::vector<std::filesystem::path> filesOfJob(const Job& job);

// The hash of a job's document, by which a saved plan names its job.
uint64_t hashOfJob(const nlohmann::ordered_json& document);

class Plan {
 public:
  // Loads scenes to determine their cameras and entries, except scenes in the plan that an earlier run wrote to
  // `saved`. A broken scene has an error and as many frame indices as the first good scene. Throws Error(Usage) if two
  // frames have the same name, if a format stores them under the same name, if two files of the set have the same name,
  // or if the renderer or a format does not support a camera.
  Plan(const Job& job, const std::filesystem::path& saved);
  void save(const std::filesystem::path& path) const;

  uint64_t frames() const { return starts_.back(); }  // number of frame indices, including those of broken scenes
  const std::vector<PlannedScene>& scenes() const { return scenes_; }
  // Returns nullopt for an index of a broken scene.
  std::optional<FrameLocation> at(uint64_t index) const;
  std::string name(uint64_t index) const;
  // Returns a frame with what is known before its scene is loaded, as Format::files() expects it.
  DataFrame frame(uint64_t index) const;
  // Returns the name of another camera's frame with the same scene and variation.
  std::string neighborName(uint64_t index, size_t camera) const { return name(index - at(index)->camera + camera); }
  const PlannedCamera& camera(FrameLocation place) const { return scenes_[place.scene].cameras[place.camera]; }
  // The hash of everything that the frame's files depend on, except the device. A finished frame with a different hash
  // is rendered again.
  uint64_t settings(uint64_t index) const;
  uint64_t hash() const;  // hash of all frames

  // Returns the loaded scene of a job with only one scene, so that it need not be loaded again. Null after the first
  // call and in other cases.
  std::unique_ptr<LoadedScene> takeScene() { return std::move(scene_); }

 private:
  bool findSaved(PlannedScene& scene, const nlohmann::ordered_json& saved) const;
  void look(PlannedScene& scene);
  std::unique_ptr<LoadedScene> load(PlannedScene& scene) const;
  std::string filledName(const std::string& source, const std::string& camera, const std::string& index,
                         const std::string& variation) const;
  void claimMemory(const PlannedScene& scene);
  void order();
  nlohmann::ordered_json describe() const;
  bool hasIndexedNames() const;
  void checkNames() const;
  void checkFiles() const;
  void checkStoredNames(const std::unordered_set<std::string>& names) const;

  const Job& job_;
  uint64_t jobHash_ = 0;   // hash of the inputs of all frames
  uint64_t loadHash_ = 0;  // hash of the job's inputs that cameras and entries of scenes depend on
  std::vector<PlannedScene> scenes_;
  std::vector<uint64_t> starts_;  // index of each scene's first frame, then the end index
  std::unique_ptr<LoadedScene> scene_;
  MemoryClaim memory_;
};

}  // namespace latelight::data
