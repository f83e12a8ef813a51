// Where cameras come from: a file source_NAME.cpp each; sources() lists them.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "data/cameras/shot.h"
#include "data/random.h"
#include "data/spec.h"

namespace latelight::data {

struct CameraContext {
  const scene::Scene& scene;
  SceneAxes axes;
  uint64_t seed;
  PictureSize size;                              // of the job's pictures, where the job says it
  const std::vector<scene::Camera>& ownCameras;  // the scene's, at the time that is asked for
};

struct CameraSource {
  std::string_view name, description;  // name: what "type" says
  // Asks for all keys that it takes.
  std::vector<Shot> (*make)(Spec& spec, const CameraContext& context);
};
std::span<const CameraSource> cameraSources();

// The cameras of one source or of a list of them; names need not be unique yet.
std::vector<Shot> makeShots(const nlohmann::ordered_json& spec, const std::string& path, const CameraContext& context);

// The most cameras that one source makes.
inline constexpr uint64_t kMostCameras = 1'000'000;

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
