// The format "boxes", one JSON file per frame. Each object has a 2D box of its visible pixels, a 2D box of its amodal
// mask, and an oriented 3D box.
#include <glm/matrix.hpp>

#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/geometry.h"
#include "data/formats/names.h"
#include "data/formats/options.h"
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
  glm::dmat4 toWorld = object.toWorld;
  toWorld[3] = object.toWorld * glm::dvec4((object.low + object.high) * 0.5, 1);
  const glm::dmat4 fromWorld = openCvFromWorld(camera);
  const glm::dvec3 size = object.high - object.low;
  Json corners = Json::array();
  for (const glm::dvec3 corner : cornersOf(object))
    corners.push_back(projected(projector, glm::dvec3(fromWorld * object.toWorld * glm::dvec4(corner, 1))));
  return {{"size", {size.x, size.y, size.z}},
          {"toWorld", output::rowsOf(toWorld)},
          {"toCamera", output::rowsOf(fromWorld * toWorld)},
          {"corners", corners}};
}

class Boxes : public Format {
 public:
  explicit Boxes(const Json& json) {
    FormatOptions options("boxes", json);
    file_ = options.frameFile("file", "boxes/{name}.json", ".json");
    whole_ = options.flag("whole", true);
    options.finish();
  }

  std::vector<output::Aov> needs() const override { return {output::Aov::Id}; }
  Extras needsExtras() const override { return {.boxes = true, .alone = whole_, .order = whole_}; }

  FrameRecord writeFrame(const DataFrame& frame, const std::filesystem::path& folder) const override {
    const std::map<uint32_t, Mask> visible = masksOf(imageOf(frame.picture, output::Aov::Id));
    const labels::Projector projector(frame.metadata.camera);
    Json objects = Json::array();
    for (const Object& object : frame.objects) {
      const auto found = visible.find(object.id);
      const Mask* mask = found == visible.end() ? nullptr : &found->second;
      if (mask || object.pixels > 0) objects.push_back(describe(frame, projector, object, mask));
    }
    const Json json{{"frame", frame.index},
                    {"name", frame.name},
                    {"width", frame.picture.width},
                    {"height", frame.picture.height},
                    {"world", frame.metadata.axes},
                    {"camera", cameraOf(frame.metadata.camera)},
                    {"objects", objects}};
    const std::string file = frameFile(file_, frame);
    writeJsonIn(folder, file, json);
    return {{file}, nullptr};
  }

 private:
  // The ids of the objects that this one is in front of, with the number of pixels.
  static Json occlusionsOf(const Object& object) {
    Json json = Json::object();
    for (const labels::Occlusion& other : object.occludes) json[std::to_string(other.id)] = other.pixels;
    return json;
  }

  static Json cameraOf(const output::CameraMetadata& camera) {
    Json json{{"K", camera.intrinsics}, {"worldToCamera", output::rowsOf(openCvFromWorld(camera))}};
    if (!camera.lens) return json;
    const scene::LensModelInfo& model = scene::infoOf(camera.lens->model);
    if (!model.calibrated) json["K"] = nullptr;
    json["model"] = model.name;
    json["distortion"] = output::distortionOf(*camera.lens);
    return json;
  }

  Json describe(const DataFrame& frame, const labels::Projector& projector, const Object& object,
                const Mask* visible) const {
    Json json{{"id", object.id}};
    if (const output::IdEntry* entry = entryOf(*frame.metadata.ids, object.id)) {
      json["node"] = nameOf(*entry);
      json["mesh"] = entry->mesh;
      json["materials"] = frame.metadata.ids->materialsOf(*entry);
    }
    const uint64_t pixels = visible ? visible->area() : 0;
    json["visible"] = extentOf(pixels, visible ? visible->box() : PixelBox{});
    if (whole_) {
      json["whole"] = extentOf(object.pixels, object.full);
      json["whole"]["pixelsInPicture"] = object.alone.area();
      json["visibleShare"] = static_cast<double>(pixels) / static_cast<double>(object.pixels);
      json["occludes"] = occlusionsOf(object);
    }
    json["box"] = boxInSpace(object, frame.metadata.camera, projector);
    return json;
  }

  std::string file_;
  bool whole_;
};

}  // namespace

std::unique_ptr<Format> makeBoxes(const Json& options) {
  return std::make_unique<Boxes>(options);
}

}  // namespace latelight::data
