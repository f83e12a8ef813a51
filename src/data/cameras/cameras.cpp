#include "data/cameras/cameras.h"

#include "base/error.h"

namespace latelight::data {

std::vector<JobCamera> makeCameras(const nlohmann::ordered_json& spec, const scene::Scene& scene, uint64_t seed) {
  std::vector<JobCamera> cameras;
  for (const scene::Camera& camera : scene.cameras) cameras.push_back({camera, camera.name});
  if (cameras.empty()) badUsage("{} has no camera", scene.source);
  return cameras;
}

}  // namespace latelight::data
