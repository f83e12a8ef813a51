#include "data/formats/object_labels.h"

#include <cmath>
#include <glm/matrix.hpp>

#include "data/formats/frame_files.h"
#include "data/formats/geometry.h"
#include "data/formats/mask_json.h"
#include "data/formats/names.h"
#include "labels/projector.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

Json extentOf(uint64_t pixels, const PixelBox& box) {
  return {{"pixels", pixels}, {"box", {box.x, box.y, box.width, box.height}}};
}

// Projects a point in the camera's frame to [x, y, depth]. Returns null for points that the camera does not project.
Json projected(const labels::Projector& projector, glm::dvec3 at) {
  const std::optional<glm::dvec3> pixel = projector.project(at);
  if (!pixel) return nullptr;
  return {pixel->x, pixel->y, pixel->z};
}

// Describes the oriented 3D box. The origin of its own frame is its center.
Json boxInSpace(const Object& object, const output::CameraMetadata& camera, const labels::Projector& projector) {
  const glm::dvec3 center = (object.low + object.high) * 0.5;
  glm::dmat4 toWorld = object.toWorld;
  toWorld[3] = object.toWorld * glm::dvec4(center, 1);
  const glm::dmat4 fromWorld = openCvFromWorld(camera);
  const glm::dvec3 size = object.high - object.low;
  Json corners = Json::array();
  for (const glm::dvec3 corner : cornersOf(object))
    corners.push_back(projected(projector, glm::dvec3(fromWorld * object.toWorld * glm::dvec4(corner, 1))));
  return {{"size", {size.x, size.y, size.z}},
          {"center", {center.x, center.y, center.z}},
          {"toWorld", output::rowsOf(toWorld)},
          {"toCamera", output::rowsOf(fromWorld * toWorld)},
          {"corners", corners}};
}

// The ids of the objects that this one is in front of, with the number of pixels.
Json occlusionsOf(const Object& object) {
  Json json = Json::object();
  for (const labels::Occlusion& other : object.occludes) json[std::to_string(other.id)] = other.pixels;
  return json;
}

Json describeCamera(const output::CameraMetadata& camera) {
  Json json{{"K", output::rowsOf(camera.intrinsics)}, {"worldToCamera", output::rowsOf(openCvFromWorld(camera))}};
  if (!camera.lens) return json;
  const scene::LensModelInfo& model = scene::infoOf(camera.lens->model);
  if (!model.calibrated) json["K"] = nullptr;
  json["model"] = model.name;
  json["distortion"] = output::distortionOf(*camera.lens);
  return json;
}

// Returns null for a point that is not known or not projected.
template <int N>
Json pointOf(const glm::vec<N, double>& point) {
  if (std::isnan(point[0])) return nullptr;
  Json json = Json::array();
  for (int i = 0; i < N; ++i) json.push_back(point[i]);
  return json;
}

Json describe(const std::string& name, const labels::ProjectedKeypoint& keypoint) {
  return {{"name", name},
          {"visibility", static_cast<uint32_t>(keypoint.visibility)},
          {"pixel", pointOf(keypoint.pixel)},
          {"depth", std::isnan(keypoint.depth) ? Json() : Json(keypoint.depth)},
          {"position", pointOf(keypoint.position)}};
}

class ObjectWriter {
 public:
  ObjectWriter(const ObjectLabels& options, const DataFrame& frame)
      : options_(options), frame_(frame), projector_(frame.metadata.camera) {}

  Json describe(const Object& object, const Mask& visible) const {
    Json json{{"id", object.id}};
    if (const output::IdEntry* entry = entryOf(*frame_.metadata.ids, object.id)) {
      json["node"] = nameOf(*entry);
      json["mesh"] = entry->mesh;
      json["materials"] = frame_.metadata.ids->materialsOf(*entry);
    }
    json["visible"] = extentOf(visible.area(), visible.box());
    if (options_.masks) json["visible"]["segmentation"] = segmentationOf(visible);
    if (options_.whole) {
      json["whole"] = extentOf(object.pixels, object.full);
      json["whole"]["pixelsInPicture"] = object.alone.area();
      if (options_.masks) json["whole"]["segmentation"] = segmentationOf(object.alone);
      json["visibleShare"] = static_cast<double>(visible.area()) / static_cast<double>(object.pixels);
      json["occludes"] = occlusionsOf(object);
    }
    json["box"] = boxInSpace(object, frame_.metadata.camera, projector_);
    addKeypoints(json, object.id);
    return json;
  }

 private:
  // The frame also has keypoints if only another format of the job requires them.
  void addKeypoints(Json& json, uint32_t id) const {
    const auto projected = frame_.keypoints.find(id);
    if (options_.keypoints.empty() || projected == frame_.keypoints.end()) return;
    Json& list = json["keypoints"] = Json::array();
    for (size_t i = 0; i < options_.keypoints.size(); ++i)
      list.push_back(data::describe(options_.keypoints[i].name, projected->second.at(i)));
  }

  const ObjectLabels& options_;
  const DataFrame& frame_;
  labels::Projector projector_;
};

}  // namespace

Json ObjectLabels::describe(const DataFrame& frame) const {
  const output::AovImage& ids = imageOf(frame.picture, output::Aov::Id);
  const std::map<uint32_t, Mask> visible = masksOf(ids);
  const Mask none{ids.width, ids.height, {ids.width * ids.height}};
  const ObjectWriter writer(*this, frame);
  Json objects = Json::array();
  for (const Object& object : frame.objects) {
    const auto found = visible.find(object.id);
    // The frame also has amodal masks if only another format of the job requires them.
    const bool isOccluded = whole && object.pixels > 0;
    if (found != visible.end() || isOccluded)
      objects.push_back(writer.describe(object, found == visible.end() ? none : found->second));
  }
  return {{"frame", frame.index},         {"name", frame.name},
          {"width", frame.picture.width}, {"height", frame.picture.height},
          {"world", frame.metadata.axes}, {"camera", describeCamera(frame.metadata.camera)},
          {"objects", std::move(objects)}};
}

}  // namespace latelight::data
