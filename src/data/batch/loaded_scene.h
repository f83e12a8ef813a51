// One worker's copy of a scene of the job. The worker applies the job's variations to it.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data/batch/camera_timeline.h"
#include "data/batch/job.h"
#include "data/variations/variations.h"

namespace latelight::data {

class LoadedScene {
 public:
  LoadedScene(const Job& job, scene::Scene scene);
  LoadedScene(const LoadedScene&) = delete;
  LoadedScene& operator=(const LoadedScene&) = delete;

  const scene::Scene& scene() const { return scene_; }
  const CameraTimeline& cameras() const { return cameras_; }
  // The ids of everything that any variation may show; null if the job has no variations or no ids.
  const std::shared_ptr<const output::IdManifest>& idsOfAll() const { return idsOfAll_; }
  // Moves the scene out of this object, with the last variation that it applied.
  scene::Scene release() && { return std::move(scene_); }
  // Applies a variation to the scene and returns the values drawn for it, or null if the job has no variations.
  const nlohmann::ordered_json& show(uint32_t variation);
  std::string environment() const;  // the current environment; empty: none
  bool hasEnvironmentInAllVariations() const;
  std::optional<double> environmentRotation() const;    // in degrees; empty if the variation does not rotate it
  std::map<uint32_t, scene::dmat4> movedNodes() const;  // Variations::movedNodes() of the variation

 private:
  std::string environmentFor(const std::string& requested) const;

  const Job& job_;
  scene::Scene scene_;
  CameraTimeline cameras_;
  std::optional<Variations> variations_;
  std::shared_ptr<const output::IdManifest> idsOfAll_;
  std::optional<uint32_t> shown_;
  nlohmann::ordered_json drawn_;
};

}  // namespace latelight::data
