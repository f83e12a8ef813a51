// Applies the random variations of a job to a scene: materials, lights, poses, visibility and so on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "output/id_manifest.h"
#include "scene/scene.h"

namespace latelight::data {

// Returns true if the variations of a job add normal maps. Scenes must then be loaded with LoadOptions::tangents.
bool addsNormalMaps(const nlohmann::ordered_json& spec);

// Edits one scene. Properties that no variation draws keep the file's values. The constructor adds all meshes,
// materials and textures that variations may use. Nothing else may edit the scene during the lifetime of this object.
class Variations {
 public:
  // `spec` is the job's "variations". The job's options `load` apply to scattered files, except for the variant and the
  // ids. Throws Error(Usage) that names the invalid key, or a name not found in the scene.
  Variations(const nlohmann::ordered_json& spec, scene::Scene& scene, uint64_t seed,
             const scene::LoadOptions& load = {});
  ~Variations();

  // Changes the scene to variation `number`, whichever variation was applied before. Returns the drawn values for the
  // manifest. The result depends only on the constructor's arguments and `number`, and is the same on every machine.
  nlohmann::ordered_json apply(uint64_t number);
  // Returns the ids of everything that any variation may show: the scene's own objects, and all that may be added. The
  // ids of added objects may differ from those in a variation, but their nodes' paths are the same. Must be called
  // before apply().
  output::IdManifest idsOfAll() const;
  // The transforms in the world of the nodes that the applied variation moves, with those below them. Their instances
  // and lights are moved already; the scene's nodes and cameras stay.
  const std::map<uint32_t, scene::dmat4>& movedNodes() const;
  // The environment of the applied variation: a file, "studio" or "none"; empty: the job's own.
  const std::string& environment() const;
  // All environments from which variations choose, by such names; empty if none chooses one.
  std::vector<std::string> possibleEnvironments() const;
  // The rotation of the environment in degrees, as for --hdri-rotate; empty: the job's own.
  std::optional<double> environmentRotation() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Returns all files that the variations of a job with the options `load` read, without a scene: environments, images,
// and scattered scenes with the files to which they refer. The order depends only on the job and the files' names.
// Missing files are included, because the constructor of Variations reports them. Throws Error(BadInput) for folders
// and scenes that cannot be read.
std::vector<std::filesystem::path> variationFiles(const nlohmann::ordered_json& spec, const scene::LoadOptions& load);

}  // namespace latelight::data
