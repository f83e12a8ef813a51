// A scene of a job as one worker has it, in whichever variation it shows.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/batch/job.h"
#include "data/cameras/cameras.h"
#include "data/variations/variations.h"

namespace latelight::data {

class LoadedScene {
 public:
  LoadedScene(const Job& job, scene::Scene scene);
  LoadedScene(const LoadedScene&) = delete;
  LoadedScene& operator=(const LoadedScene&) = delete;

  const scene::Scene& scene() const { return scene_; }
  const std::vector<JobCamera>& cameras() const { return cameras_; }  // each with its size
  // From then on it is as that variation has it; what was drawn for it. Null where nothing varies.
  const nlohmann::ordered_json& show(uint32_t variation);
  std::string environment() const;                    // as it is now; empty: none
  std::optional<double> environmentRotation() const;  // degrees, where the variation turns it

 private:
  const Job& job_;
  scene::Scene scene_;
  MemoryClaim memory_;  // of the cameras
  std::vector<JobCamera> cameras_;
  std::optional<Variations> variations_;
  std::optional<uint32_t> shown_;
  nlohmann::ordered_json drawn_;
};

}  // namespace latelight::data
