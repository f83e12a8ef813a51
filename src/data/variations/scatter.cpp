// The variation "scatter": adds objects at random positions on a node's surface or in a box, without overlap. Positions
// are drawn by rejection sampling, and overlap is tested with oriented bounding boxes.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "base/log.h"
#include "data/scene_files.h"
#include "data/stop.h"
#include "data/variations/draws.h"
#include "data/variations/frames.h"
#include "data/variations/object_template.h"
#include "data/variations/pattern.h"
#include "data/variations/surface.h"
#include "data/variations/variation.h"
#include "scene/file_frame.h"
#include "scene/load/load.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;
using glm::dmat4, glm::dvec3, glm::dvec4;

constexpr uint64_t kMaxObjects = 1'000'000;

// Returns a light that a transform in the world has moved. As below a scaled node of glTF, its intensity stays.
scene::Light moved(scene::Light light, const dmat4& transform) {
  light.position = dvec3(transform * dvec4(light.position, 1));
  light.direction = glm::vec3(glm::normalize(dvec3(transform * dvec4(light.direction, 0))));
  light.axes = glm::mat3(glm::dmat3(transform) * glm::dmat3(light.axes));
  return light;
}

class Scatter : public Variation {
 public:
  Scatter(Spec& spec, const VariationContext& context) : path_(spec.path()) {
    const scene::Scene& scene = context.scene;
    for (Spec& object : spec.objects("objects")) templates_.push_back(readTemplate(object, context));
    count_ = spec.counts("count", kMaxObjects);
    if (spec.has("on") == spec.has("min")) badUsage("{} needs either \"on\", a node, or \"min\" and \"max\"", path_);
    if (spec.has("on"))
      surface_.emplace(scene, spec.text("on"), spec.number("slope", {0, 90}, 30.0), spec.pathOf("on"));
    else
      volume_ = {spec.vector("min"), spec.vector("max")};
    for (int axis = 0; axis < 3; ++axis)
      if (volume_.low[axis] > volume_.high[axis])
        badUsage("{} must be at most {} along each axis", spec.pathOf("min"), spec.pathOf("max"));
    scale_ = spec.interval("scale", kPositive, Interval{1, 1});
    turn_ = spec.interval("turn", {}, Interval{0, 360});
    spacing_ = spec.number("spacing", kNotNegative, 0.0);
    tries_ = spec.count("tries", 1, 1'000'000, 100);
    if (spec.has("avoid")) obstacles_ = boxesOf(scene, selectNodes(spec, "avoid", scene));
    name_ = spec.text("name", "scattered");
    if (name_.find('/') != std::string::npos) badUsage("{} must not contain a slash", spec.pathOf("name"));
  }

  Json draw(const Draw& draw, Draft& draft) const override {
    const uint32_t count = drawn(count_, draw.of(path_ + "/count"));
    Json record{{"wanted", count}, {"objects", Json::array()}};
    for (uint32_t i = 0; i < count; ++i) {
      Random random = draw.of(fmt::format("{}/{}", path_, i));
      const ObjectTemplate& object = templates_[random.below(static_cast<uint32_t>(templates_.size()))];
      const auto place = findPlace(object, random, draft);
      if (!place) continue;
      AddedObject& added = draft.addedObjects.emplace_back();
      added.name = nameOf(i);
      for (const scene::ObjectPart& part : object.parts)
        added.parts.push_back({part.mesh, part.material, *place * part.toWorld});
      added.copy = object.copy;
      if (added.copy) added.copy->displacement = *place;
      for (const scene::Light& light : object.lights) draft.addedLights.push_back(moved(light, *place));
      draft.taken.push_back(transformed(object.box, *place));
      record["objects"].push_back(describe(added.name, object, *place, draft.scene));
    }
    return record;
  }

  std::vector<AddedObject> possibleObjects() const override {
    std::vector<AddedObject> objects;
    for (uint64_t i = 0; i < std::max<uint64_t>(count_.high, templates_.size()); ++i)
      objects.push_back({nameOf(i), templates_[i % templates_.size()].parts, {}});
    return objects;
  }

 private:
  std::string nameOf(uint64_t number) const { return fmt::format("{}-{}", name_, number); }

  static std::vector<OrientedBox> boxesOf(const scene::Scene& scene, const std::vector<uint32_t>& nodes) {
    const auto above = selectedAbove(scene, nodes);
    std::vector<OrientedBox> boxes;
    for (size_t i = 0; i < above.size(); ++i) {
      if (above[i].empty()) continue;
      const scene::Mesh& mesh = scene.meshes[scene.instances[i].mesh];
      OrientedBox box{.center = dvec3(mesh.boundsMin + mesh.boundsMax) * 0.5};
      for (int axis = 0; axis < 3; ++axis) box.half[axis] *= (mesh.boundsMax[axis] - mesh.boundsMin[axis]) * 0.5;
      boxes.push_back(transformed(box, scene.instances[i].toWorld));
    }
    return boxes;
  }

  // Returns the transform that moves the template to a free random position, or nullopt if all tries fail. Scale and
  // turn are drawn only once: if each try drew them again, objects that fit easily would be more frequent, so that
  // neither would be uniform.
  std::optional<dmat4> findPlace(const ObjectTemplate& object, Random& random, const Draft& draft) const {
    const double scale = random.between(scale_.low, scale_.high);
    dmat4 place = turnAbout({0, 0, 1}, random.between(turn_.low, turn_.high));
    for (int axis = 0; axis < 3; ++axis) place[axis] *= scale;
    // The anchor is the center of the box's underside on a surface, and the center of the box in a volume.
    dvec3 anchor = object.box.center;
    if (surface_) anchor -= object.box.half[2];
    for (uint64_t tried = 0; tried < tries_; ++tried) {
      throwIfStopped();
      const dvec3 at = surface_ ? surface_->point(random) : pointInVolume(random, draft.scene);
      place[3] = dvec4(at - dvec3(place * dvec4(anchor, 0)), 1);
      if (isFree(transformed(object.box, place), draft)) return place;
    }
    return std::nullopt;
  }

  dvec3 pointInVolume(Random& random, const scene::Scene& scene) const {
    const double x = random.between(volume_.low.x, volume_.high.x), y = random.between(volume_.low.y, volume_.high.y);
    const double z = random.between(volume_.low.z, volume_.high.z);
    return dvec3(worldFromFile(scene) * dvec4(x, y, z, 1));
  }

  bool isFree(const OrientedBox& box, const Draft& draft) const {
    if (!surface_) {
      const OrientedBox inFile = transformed(box, fileFromWorld(draft.scene));
      for (int axis = 0; axis < 3; ++axis) {
        dvec3 along(0);
        along[axis] = 1;
        const double extent = extentAlong(inFile, along);
        if (inFile.center[axis] - extent < volume_.low[axis] || inFile.center[axis] + extent > volume_.high[axis])
          return false;
      }
    }
    const auto apart = [&](const OrientedBox& other) { return areApart(box, other, spacing_); };
    return std::ranges::all_of(draft.taken, apart) && std::ranges::all_of(obstacles_, apart);
  }

  // Describes an object for the manifest. "transform" is a matrix in the file's frame, as a list of rows.
  static Json describe(const std::string& name, const ObjectTemplate& object, const dmat4& place,
                       const scene::Scene& scene) {
    const dmat4 inFile = fileFromWorld(scene) * place * worldFromFile(scene);
    Json rows = Json::array();
    for (int row = 0; row < 4; ++row) rows.push_back({inFile[0][row], inFile[1][row], inFile[2][row], inFile[3][row]});
    return {{"node", "/" + name}, {"object", object.name}, {"transform", rows}};
  }

  std::string path_, name_;
  std::vector<ObjectTemplate> templates_;
  Spec::Counts count_;
  std::optional<Surface> surface_;
  Spec::Corners volume_;
  Interval scale_, turn_;  // turn: in degrees, about the world's up axis
  double spacing_ = 0;
  uint64_t tries_ = 0;
  std::vector<OrientedBox> obstacles_;
};

}  // namespace

std::vector<std::filesystem::path> scatterFiles(const Json& value, const scene::LoadOptions& load) {
  std::vector<std::filesystem::path> files;
  for (const Json& object : value.value("objects", Json())) {
    const Json file = object.is_object() ? object.value("file", Json()) : Json();
    if (!file.is_string()) continue;
    const auto source = file.get<std::string>();
    scene::LoadOptions options{.allowOutside = load.allowOutside, .textures = listsFilesOnlyWithTextures(source)};
    if (!scene::definesFrame(source)) options.pointRadius = 1;  // required for points; any radius lists the same files
    std::vector<std::string> ignored;                           // the load that renders the file repeats its warnings
    const WarningCapture capture(ignored);
    const scene::Scene scene = scene::load(source, options);
    files.insert(files.end(), scene.files.begin(), scene.files.end());
  }
  return files;
}

std::unique_ptr<Variation> scatterObjects(Spec& spec, const VariationContext& context) {
  return std::make_unique<Scatter>(spec, context);
}

}  // namespace latelight::data
