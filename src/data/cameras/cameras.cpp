#include "data/cameras/cameras.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "base/error.h"
#include "data/cameras/calibrated.h"
#include "data/cameras/source.h"
#include "data/stop.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr CameraSource kSources[] = {
    {"scene", "the scene's own cameras", shotsOfScene},
    {"list", "cameras one by one, by what they look at or by their poses", shotsOfList},
    {"orbit", "a circle or a spiral around a target", shotsOnOrbit},
    {"sphere", "points on a sphere around a target, or in a shell", shotsOnSphere},
    {"box", "random points in a box", shotsInBox},
    {"path", "a smooth path through key frames", shotsOnPath},
    {"transforms", "a transforms.json of nerfstudio or instant-ngp", shotsOfTransforms},
    {"colmap", "a model of COLMAP, text or binary", shotsOfColmap},
    {"tum", "a trajectory in TUM's format", shotsOfTum},
    {"bop", "a scene_camera.json of BOP", shotsOfBop},
    {"stereo", "a pair for each of other cameras", shotsOfStereo},
    {"rig", "several for each of other cameras, where offsets say", shotsOfRig},
};

std::vector<Shot> makeSource(const Json& value, const std::string& path, const CameraContext& context) {
  Spec spec(value, path);
  const std::string type = spec.text("type");
  const auto source = std::ranges::find(kSources, type, &CameraSource::name);
  if (source == std::end(kSources)) {
    std::vector<std::string_view> names;
    for (const CameraSource& known : kSources) names.push_back(known.name);
    badUsage("{}.type must be one of {}, not \"{}\"", path, fmt::join(names, ", "), type);
  }
  throwIfStopped();
  std::vector<Shot> shots = source->make(spec, context);
  const CameraExposure exposure = readExposure(spec);
  for (Shot& shot : shots) shot.exposure = combined(shot.exposure, exposure);
  spec.finish();
  return shots;
}

// Returns the number of cameras that sources declare, before any is created. A file counts as one camera until it is
// read, and so does an invalid source.
double statedCount(const Json& sources) {
  if (sources.is_array()) {
    double sum = 0;
    for (const Json& source : sources) sum += statedCount(source);
    return sum;
  }
  if (!sources.is_object()) return 1;
  const auto member = [&](const char* key) { return sources.value(key, Json()); };
  const Json type = member("type");
  if (type == "stereo") return 2 * statedCount(member("cameras"));
  if (type == "rig") return double(member("offsets").size()) * statedCount(member("cameras"));
  if (type == "list") return double(member("cameras").size());
  const Json count = member("count");
  return count.is_number() ? count.get<double>() : 1;
}

// Returns a name that is valid as part of a file name.
std::string fileName(std::string name, size_t index) {
  std::ranges::replace_if(
      name, [](unsigned char c) { return c == '/' || c == '\\' || c < 0x20; }, '_');
  return name.empty() || name == "." || name == ".." ? fmt::format("camera{}", index) : name;
}

void makeNamesUnique(std::vector<JobCamera>& cameras) {
  std::unordered_set<std::string> taken;
  std::unordered_map<std::string, uint64_t> twins;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const std::string baseName = fileName(cameras[i].name, i);
    std::string name = baseName;
    while (!taken.insert(name).second)
      name = fmt::format("{}-{}", baseName, ++twins.try_emplace(baseName, 1).first->second);
    cameras[i].name = cameras[i].camera.name = name;
  }
}

}  // namespace

std::string memberName(std::string_view pose, std::string_view member) {
  return fmt::format("{}-{}", pose, member);
}

std::span<const CameraSource> cameraSources() {
  return kSources;
}

std::vector<Shot> makeShots(const Json& spec, const std::string& path, const CameraContext& context) {
  if (!spec.is_array()) return makeSource(spec, path, context);
  if (spec.empty()) badUsage("{} is an empty list: give at least one source of cameras", path);
  std::vector<Shot> all;
  for (size_t i = 0; i < spec.size(); ++i) {
    const size_t before = all.size();
    for (Shot& shot : makeSource(spec[i], fmt::format("{}[{}]", path, i), context)) {
      if (shot.sequence)
        for (std::optional<size_t>* neighbor : {&shot.sequence->previous, &shot.sequence->next})
          if (*neighbor) **neighbor += before;
      all.push_back(std::move(shot));
    }
  }
  return all;
}

std::string numberedName(std::string_view stem, uint64_t number, uint64_t count) {
  return fmt::format("{}{:0{}}", stem, number, fmt::formatted_size("{}", count - 1));
}

std::vector<JobCamera> makeCameras(const Json& spec, const scene::Scene& scene, uint64_t seed,
                                   const CameraInputs& inputs, MemoryClaim* memory) {
  const Json scenes = {{"type", "scene"}};
  const Json& sources = spec.is_null() ? scenes : spec;
  if (statedCount(sources) > double(kMaxCamerasOfScene))
    badUsage("cameras describes {:.0f} cameras, counting rigs and stereo pairs; at most {} are supported per scene",
             statedCount(sources), kMaxCamerasOfScene);
  CameraBudget budget;
  const std::vector<scene::Camera> own = scene::posedCameras(scene, inputs.pose);
  const CameraContext context{scene, axesOf(scene), seed, inputs.size, own, budget};
  std::vector<JobCamera> cameras;
  for (const Shot& shot : makeShots(sources, "cameras", context)) cameras.push_back(toJobCamera(shot, scene));
  makeNamesUnique(cameras);
  if (memory) *memory = budget.keep();
  return cameras;
}

}  // namespace latelight::data
