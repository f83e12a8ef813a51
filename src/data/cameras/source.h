// The interface of camera sources. Each source is a file source_NAME.cpp; cameraSources() lists them.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/memory.h"
#include "data/cameras/shot.h"
#include "data/random.h"
#include "data/spec.h"

namespace latelight::data {

// Counts the cameras of one scene and claims their memory before they are created, because rigs and pairs multiply
// them.
class CameraBudget {
 public:
  // Throws Error(Usage) whose message begins with `path` if there are too many cameras, and Error(OutOfMemory) if
  // memory runs out.
  void take(double count, double nameBytes, const std::string& path);
  // Returns the claim on the finished cameras. The claim on temporary data ends with this object.
  MemoryClaim keep() { return std::move(kept_); }

 private:
  double count_ = 0;
  MemoryClaim working_, kept_;
};

struct CameraContext {
  const scene::Scene& scene;
  SceneAxes axes;
  uint64_t seed;
  PictureSize size;                              // picture size from the job; 0 x 0 if it does not specify one
  const std::vector<scene::Camera>& ownCameras;  // the scene's cameras, at the requested time
  CameraBudget& budget;
  // Set by rigs and pairs that contain the source: the number of cameras that each of its cameras becomes, and the
  // bytes that they add to its name.
  double copies = 1, nameBytes = 0;

  // Every source calls this before it creates its cameras. `names` is the size of all their names in bytes.
  void claim(const Spec& spec, uint64_t count, uint64_t names) const {
    budget.take(copies * double(count), copies * (double(names) + double(count) * nameBytes), spec.path());
  }
};

struct CameraSource {
  std::string_view name, description;  // name: the value of "type"
  // Creates the cameras, and reads every key that the source accepts, so that all other keys can be rejected.
  std::vector<Shot> (*make)(Spec& spec, const CameraContext& context);
};
std::span<const CameraSource> cameraSources();

// Creates the cameras of one source or of a list of sources. Names are not necessarily unique yet.
std::vector<Shot> makeShots(const nlohmann::ordered_json& spec, const std::string& path, const CameraContext& context);

// The maximum number of cameras of one source, and of all sources together.
inline constexpr uint64_t kMaxCameras = 1'000'000, kMaxCamerasOfScene = 10'000'000;
// An upper bound for the size of names from numberedName().
inline constexpr uint64_t kNumberedNameBytes = 16;

// Returns a stem with a zero-padded number, such as "orbit07" of 100.
std::string numberedName(std::string_view stem, uint64_t number, uint64_t count);

std::vector<Shot> shotsOfScene(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOfList(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOnOrbit(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOnSphere(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsInBox(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOnPath(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOfTransforms(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOfColmap(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOfTum(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOfBop(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOfStereo(Spec& spec, const CameraContext& context);
std::vector<Shot> shotsOfRig(Spec& spec, const CameraContext& context);

}  // namespace latelight::data
