// Loads the scenes of a plan, for several workers at once.
#pragma once

#include <memory>
#include <mutex>

#include "data/batch/plan.h"

namespace latelight::data {

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
