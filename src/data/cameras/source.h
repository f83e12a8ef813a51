// Where cameras come from: a file source_NAME.cpp each; sources() lists them.
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

// The cameras of one scene, counted and claimed before they are made: rigs and pairs multiply them.
class CameraBudget {
 public:
  // Throws Error: Usage that begins with `path` where there are too many, DeviceLost where there is no memory.
  void take(double count, double nameBytes, const std::string& path);
  // Gives back what only making them took.
  MemoryClaim keep() { return std::move(kept_); }

 private:
  double count_ = 0;
  MemoryClaim making_, kept_;
};

struct CameraContext {
  const scene::Scene& scene;
  SceneAxes axes;
  uint64_t seed;
  PictureSize size;                              // of the job's pictures, where the job says it
  const std::vector<scene::Camera>& ownCameras;  // the scene's, at the time that is asked for
  CameraBudget& budget;
  // Rigs and pairs around a source: how many cameras each of its cameras becomes, and what they add to its name.
  double copies = 1, nameBytes = 0;

  // Every source calls this before it makes its cameras. `names`: bytes of all their names.
  void claim(const Spec& spec, uint64_t count, uint64_t names) const {
    budget.take(copies * double(count), copies * (double(names) + double(count) * nameBytes), spec.path());
  }
};

struct CameraSource {
  std::string_view name, description;  // name: what "type" says
  // Asks for all keys that it takes.
  std::vector<Shot> (*make)(Spec& spec, const CameraContext& context);
};
std::span<const CameraSource> cameraSources();

// The cameras of one source or of a list of them; names need not be unique yet.
std::vector<Shot> makeShots(const nlohmann::ordered_json& spec, const std::string& path, const CameraContext& context);

// The most cameras that one source makes, and all sources together.
inline constexpr uint64_t kMostCameras = 1'000'000, kMostCamerasOfScene = 10'000'000;
// Names by numberedName() are shorter.
inline constexpr uint64_t kNumberedNameBytes = 16;

// "orbit007" of 100.
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
