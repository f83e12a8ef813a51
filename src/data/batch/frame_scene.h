// The scene of one frame of a job, for files that other programs render.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "data/batch/job.h"

namespace latelight::data {

struct FrameScene {
  std::string name;    // of the frame
  scene::Scene scene;  // with the frame's variation, at its time, with its camera as the only one
  // The options of `latelight render` with which a file of the scene gives the frame's picture.
  std::vector<std::string> options;
  std::vector<std::filesystem::path> files;  // that the scene, its cameras and its variations are read from
};

// Throws Error(Usage) if the job has no such frame, and Error(BadInput) if its scene cannot be loaded. Warns about
// properties of the frame that the scene cannot hold.
FrameScene sceneOfFrame(const Job& job, uint64_t frame);

}  // namespace latelight::data
