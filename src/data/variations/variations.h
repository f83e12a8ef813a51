// What a job changes of a scene from frame to frame: materials, lights, poses, what is visible, and so on.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "scene/scene.h"

namespace latelight::data {

// Bound to a scene, which it edits; what it does not draw keeps the file's values. Meshes, materials and textures that
// it may show are added to the scene when it is made. Nothing else may edit the scene while it exists.
class Variations {
 public:
  // `spec` is the job's "variations"; throws Error(Usage) that names the key that is wrong, or a name that the scene
  // has not.
  Variations(const nlohmann::ordered_json& spec, scene::Scene& scene, uint64_t seed);
  ~Variations();

  // The scene as variation `number` has it, whatever it was before; says what was drawn, for the manifest. It depends
  // on the seed and the number alone, and is the same on every machine.
  nlohmann::ordered_json apply(uint64_t number);
  // The environment that the last one drew: a file or "studio"; empty: the job's own.
  const std::string& environment() const;
  // How far the last one turned it, degrees, as --hdri-rotate; none: the job's own.
  std::optional<double> environmentRotation() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::data
