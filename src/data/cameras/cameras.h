// The cameras of a data set, as a job describes them: from files, or made.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/memory.h"
#include "scene/scene.h"

namespace latelight::data {

// Pixels; 0 and 0 where nothing says the size.
struct PictureSize {
  uint32_t width = 0, height = 0;
};

// The place of a camera in a sequence: the poses of one source, in their order. Lists, spheres and boxes have no order.
struct SequencePlace {
  uint64_t number = 0;                   // from 0
  std::optional<double> seconds{};       // since the first pose, where the source has times
  std::optional<size_t> previous, next;  // the neighbors in the whole list of cameras; none at the ends
};

struct JobCamera {
  scene::Camera camera;
  std::string name;                // unique in the list; part of frames' names where the job has them
  uint32_t width = 0, height = 0;  // pixels; 0: the job's
  std::optional<SequencePlace> sequence{};
  bool followsScene = false;  // its pose is that of a camera of the scene, which animations may move
};

struct CameraInputs {
  PictureSize size;  // of the job's pictures, where the job says it
  scene::Pose pose;  // of the scene's own cameras; empty: at rest
};

// The cameras that `spec`, a job's "cameras", describes for a scene. The same on every machine for the same seed.
// `memory`: of the cameras, to be kept as long as they are. Throws Error: Usage names the key that is wrong, BadInput a camera file that is broken.
std::vector<JobCamera> makeCameras(const nlohmann::ordered_json& spec, const scene::Scene& scene, uint64_t seed,
                                   const CameraInputs& inputs = {}, MemoryClaim* memory = nullptr);

}  // namespace latelight::data
