// A scene of a job as one worker has it, in whichever variation it shows.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "data/batch/plan.h"
#include "data/variations/variations.h"

namespace latelight::data {

class LoadedScene {
 public:
  LoadedScene(const Job& job, scene::Scene scene);

  const scene::Scene& scene() const { return scene_; }
  const JobCamera& camera(uint32_t index) const { return cameras_[index]; }
  size_t cameras() const { return cameras_.size(); }
  // From then on it is as that variation has it; what was drawn for it. Null where nothing varies.
  const nlohmann::ordered_json& show(uint32_t variation);
  std::string environment() const;  // as it is now; empty: none

 private:
  const Job& job_;
  scene::Scene scene_;
  std::vector<JobCamera> cameras_;
  std::optional<Variations> variations_;
  std::optional<uint32_t> shown_;
  nlohmann::ordered_json drawn_;
};

// Loads them, for several workers at once.
class SceneLoader {
 public:
  SceneLoader(const Job& job, Plan& plan) : job_(job), plan_(plan) {}
  // Throws Error where it can't be loaded, or is not what was planned.
  std::unique_ptr<LoadedScene> load(uint32_t scene);

 private:
  const Job& job_;
  Plan& plan_;
  std::mutex mutex_;
};

}  // namespace latelight::data
