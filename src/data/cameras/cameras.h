// The cameras of a data set, as a job describes them: from files, or made.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/memory.h"
#include "scene/scene.h"

namespace latelight::data {

struct JobCamera {
  scene::Camera camera;
  std::string name;                // unique in the list; part of frames' names where the job has them
  uint32_t width = 0, height = 0;  // pixels; 0: the job's
};

// The cameras that `spec`, a job's "cameras", describes for a scene. The same on every machine for the same seed.
// Throws Error: Usage names the key that is wrong, BadInput a camera file that is broken.
// `memory`: of the cameras, to be kept as long as they are.
std::vector<JobCamera> makeCameras(const nlohmann::ordered_json& spec, const scene::Scene& scene, uint64_t seed,
                                   MemoryClaim* memory = nullptr);

}  // namespace latelight::data
