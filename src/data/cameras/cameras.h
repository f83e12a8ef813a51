// Creates the cameras of a data set from a job's description, either read from files or generated.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/memory.h"
#include "data/cameras/exposure.h"
#include "scene/scene.h"

namespace latelight::data {

// In pixels; 0 x 0 if no size is specified.
struct PictureSize {
  uint32_t width = 0, height = 0;
};

// The position of a camera in a sequence, the ordered poses of one source. Lists, spheres and boxes are not sequences.
struct SequencePosition {
  uint64_t number = 0;                   // from 0
  std::optional<double> seconds{};       // since the first pose; empty if the source has no times
  std::optional<size_t> previous, next;  // indices in the list of all cameras; empty at the ends
};

struct JobCamera {
  scene::Camera camera;
  std::string name;                // unique in the list; part of frame names that contain {camera}
  uint32_t width = 0, height = 0;  // in pixels; 0: the job's size
  std::optional<SequencePosition> sequence{};
  CameraExposure exposure{};
  // Index of the scene's camera that it follows, which animations and variations may move; empty: it follows none.
  std::optional<uint32_t> sceneCamera{};
  std::string member{};  // its name in its pair or rig, such as left; of nested rigs from the inside to the outside
};

// Returns the name of a member of a pair or a rig at a pose, such as path0-left.
std::string memberName(std::string_view pose, std::string_view member);

struct CameraInputs {
  PictureSize size;  // picture size from the job; 0 x 0 if the job does not specify it
  scene::Pose pose;  // pose of the scene's own cameras; empty: at rest
};

// Creates the cameras that `spec`, a job's "cameras", describes for a scene. The result is the same on every machine
// and depends only on the arguments and on camera files. `memory` receives the claim on the cameras' memory and must
// live as long as they do. Throws Error(Usage) that names the invalid key, and Error(BadInput) that names the invalid
// camera file.
std::vector<JobCamera> makeCameras(const nlohmann::ordered_json& spec, const scene::Scene& scene, uint64_t seed,
                                   const CameraInputs& inputs = {}, MemoryClaim* memory = nullptr);

}  // namespace latelight::data
