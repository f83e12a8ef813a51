// Loads the scenes of a plan. Several workers may call it concurrently.
#pragma once

#include <memory>
#include <mutex>

#include "data/batch/plan.h"

namespace latelight::data {

class SceneLoader {
 public:
  SceneLoader(const Job& job, Plan& plan) : job_(job), plan_(plan) {}
  // Throws Error if the scene cannot be loaded, or if its number of cameras differs from the plan.
  std::unique_ptr<LoadedScene> load(uint32_t scene);

 private:
  const Job& job_;
  Plan& plan_;
  std::mutex mutex_;
};

}  // namespace latelight::data
