#include "data/batch/frame_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/log.h"
#include "data/batch/scene_loader.h"
#include "data/batch/set.h"
#include "render/options/options.h"
#include "scene/aperture.h"
#include "scene/bake.h"
#include "scene/environment/environment.h"
#include "scene/framing.h"
#include "scene/lens.h"

namespace latelight::data {

namespace {

// A list of options in which later values replace earlier ones.
class OptionWords {
 public:
  explicit OptionWords(const Job& job) {
    for (const render::Option& option : render::options())
      if (const auto given = job.given.find(render::keyOf(option)); given != job.given.end())
        values_[option.name] = option.kind == render::OptionKind::Flag ? "" : given->second;
  }

  void set(std::string_view name, std::string value) { values_[std::string(name)] = std::move(value); }
  void remove(std::string_view name) { values_.erase(std::string(name)); }

  std::vector<std::string> words() const {
    std::vector<std::string> words;
    for (const auto& [name, value] : values_) words.push_back(value.empty() ? name : name + "=" + value);
    return words;
  }

 private:
  std::map<std::string, std::string> values_;
};

// --- ids ------------------------------------------------------------------------------------------------------------

// Paths of added nodes whose instances are in several places: in a file, those are nodes below, with ids of their own.
std::vector<std::string> scatteredGroups(const scene::Scene& scene) {
  std::map<uint32_t, glm::dmat4> places;  // of the first instance, by node
  std::set<uint32_t> spread;
  for (const scene::Instance& instance : scene.instances) {
    if (instance.removed || scene.nodes[instance.node].added < 2) continue;
    if (places.try_emplace(instance.node, instance.toWorld).first->second != instance.toWorld)
      spread.insert(instance.node);
  }
  std::vector<std::string> paths;
  for (const uint32_t node : spread) paths.push_back(scene.nodes[node].path);
  return paths;
}

std::vector<std::string> nodesAtDepth(const scene::Scene& scene, uint32_t depth) {
  std::vector<std::string> paths;
  std::vector<uint32_t> depths(scene.nodes.size());
  for (size_t i = 0; i < scene.nodes.size(); ++i) {  // parents first
    const int parent = scene.nodes[i].parent;
    depths[i] = parent < 0 ? 0 : depths[static_cast<size_t>(parent)] + 1;
    if (depths[i] == depth && !scene.nodes[i].path.empty()) paths.push_back(scene.nodes[i].path);
  }
  return paths;
}

void setIds(const scene::IdGrouping& grouping, const scene::Scene& scene, OptionWords& options) {
  std::vector<std::string> nodes = scatteredGroups(scene);
  if (grouping.depth && (nodes.empty() || *grouping.depth == 0))
    return options.set("--id-depth", fmt::format("{}", *grouping.depth));
  const std::vector<std::string> others = grouping.depth ? nodesAtDepth(scene, *grouping.depth) : grouping.nodes;
  nodes.insert(nodes.end(), others.begin(), others.end());
  if (!nodes.empty()) options.set("--id-nodes", fmt::format("{}", fmt::join(nodes, ",")));
}

// --- the camera -----------------------------------------------------------------------------------------------------

std::string lensText(const scene::Lens& lens) {
  const scene::LensModelInfo& info = scene::infoOf(lens.model);
  if (!info.calibrated) return info.name;
  std::string text = fmt::format("{}:{},{},{},{}", info.name, lens.fx, lens.fy, lens.cx, lens.cy);
  for (size_t i = 0; i < info.coefficients; ++i) text += fmt::format(",{}", lens.distortion[i]);
  return text;
}

// The lens of a camera whose image center is shifted.
scene::Lens shiftedLens(const scene::Camera& camera, double width, double height) {
  const double focal = height / 2 / std::tan(double{camera.verticalFov} / 2);
  return {.model = scene::LensModel::Pinhole,
          .width = width,
          .height = height,
          .fx = focal,
          .fy = focal,
          .cx = width / 2 * (1 + double{camera.principal.x}),
          .cy = height / 2 * (1 - double{camera.principal.y})};
}

// Replaces what glTF's cameras do not have by options of `render`. The camera's own field of view is then that of the
// lens without distortion, for other programs.
void simplifyLens(const JobCamera& from, scene::Camera& camera, OptionWords& options) {
  const bool isShifted = camera.principal != glm::vec2(0);
  if (!camera.lens && !isShifted) return;
  const double width = from.width, height = from.height;
  if (camera.orthographic)
    return warn("the camera {} has a shifted center, which glTF's cameras do not have", camera.name);
  const scene::Lens lens =
      camera.lens ? scene::scaledTo(*camera.lens, from.width, from.height) : shiftedLens(camera, width, height);
  options.set("--lens", lensText(lens));
  warn("the camera {} has a lens or a shifted center, which glTF's cameras do not have: render its picture with --lens",
       camera.name);
  const bool hasFocalLength = scene::infoOf(lens.model).calibrated && lens.model != scene::LensModel::FTheta;
  const auto angle = static_cast<float>(2 * std::atan2(height / 2, lens.fy));
  camera.verticalFov = hasFocalLength && scene::isUsableFieldOfView(angle) ? angle : scene::kDefaultVerticalFov;
  camera.principal = {};
  camera.lens.reset();
}

scene::Camera cameraOf(const JobCamera& from, OptionWords& options) {
  scene::Camera camera = from.camera;
  camera.name = from.name;
  camera.node = -1;
  options.set("--size", fmt::format("{}x{}", from.width, from.height));
  if (camera.aperture) options.set("--aperture", scene::apertureText(*camera.aperture));
  if (camera.focusDistance) options.set("--focus-distance", fmt::format("{}", *camera.focusDistance));
  if (from.exposure.ev) options.set("--exposure", fmt::format("{}", *from.exposure.ev));
  simplifyLens(from, camera, options);
  return camera;
}

// The file holds an instant, at which nothing moves.
void dropTime(const render::Settings& settings, const std::string& name, OptionWords& options) {
  for (const char* option : {"--time", "--fps", "--animation", "--loop", "--shutter", "--readout"})
    options.remove(option);
  if (settings.shutter > 0 || settings.readout != 0)
    warn("the frame {} is exposed while the camera or the scene may move: the file holds its middle only", name);
}

// An environment of the scene file has no name of its own, under which another file could refer to it.
void setEnvironment(const LoadedScene& loaded, OptionWords& options) {
  if (const auto degrees = loaded.environmentRotation()) options.set("--hdri-rotate", fmt::format("{}", *degrees));
  const std::string name = loaded.environment();
  const auto& own = loaded.scene().environment;
  if (!own || own->name != name) options.set("--hdri", name.empty() ? "none" : name);
}

// The reason that the scene of a frame cannot be loaded.
const std::string& errorOf(const Plan& plan, uint64_t index) {
  auto scene = plan.scenes().begin();
  for (; index >= scene->places; ++scene) index -= scene->places;
  return scene->error;
}

}  // namespace

FrameScene sceneOfFrame(const Job& job, uint64_t index) {
  Plan plan(job, SetFolder(job.folder).plan());
  if (index >= plan.frames())
    badUsage("the job has {} frames, numbered from 0: there is no frame {}", plan.frames(), index);
  const auto place = plan.at(index);
  if (!place) badInput("{}", errorOf(plan, index));
  const std::unique_ptr<LoadedScene> loaded = SceneLoader(job, plan).load(place->scene);
  loaded->show(place->variation);
  const CameraTimeline& cameras = loaded->cameras();
  FrameScene frame{.name = plan.name(index)};
  OptionWords options(job);
  dropTime(cameras.settingsOf(place->camera), frame.name, options);
  setEnvironment(*loaded, options);
  const scene::Pose pose = cameras.poses(place->camera).current;
  const scene::Camera camera = cameraOf(cameras.camera(place->camera), options);
  const std::map<uint32_t, scene::dmat4> moved = loaded->movedNodes();
  frame.scene = std::move(*loaded).release();
  if (!frame.scene.yUp && !job.given.contains("axes")) options.set("--axes", "z-up");
  setIds(job.load.ids, frame.scene, options);
  scene::bakePose(frame.scene, pose, moved);
  frame.scene.cameras = {camera};
  frame.options = options.words();
  frame.files = filesOfJob(job);
  frame.files.insert(frame.files.end(), frame.scene.files.begin(), frame.scene.files.end());
  return frame;
}

}  // namespace latelight::data
