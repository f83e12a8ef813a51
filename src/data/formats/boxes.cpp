// The format "boxes", one JSON file per frame. Each object has a 2D box of its visible pixels, a 2D box of its amodal
// mask, and an oriented 3D box.
#include <glm/matrix.hpp>

#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/geometry.h"
#include "data/formats/names.h"
#include "data/formats/options.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

Json extentOf(uint64_t pixels, const PixelBox& box) {
  return {{"pixels", pixels}, {"box", {box.x, box.y, box.width, box.height}}};
}

// The projection of a frame's camera.
struct Projector {
  const output::CameraMetadata& camera;
  std::optional<scene::LensProjection> lens;
  explicit Projector(const output::CameraMetadata& metadata) : camera(metadata) {
    if (metadata.lens) lens.emplace(*metadata.lens);
  }
};

// Projects a point in the camera's frame to [x, y, depth]. Returns null for points behind a perspective camera and for
// points that the lens does not project.
Json projected(const Projector& projector, glm::dvec3 at) {
  const output::CameraMetadata& camera = projector.camera;
  if (projector.lens) {
    const double distance = glm::length(at);
    const std::optional<glm::dvec2> pixel = distance > 0 ? projector.lens->project(at) : std::nullopt;
    if (!pixel) return nullptr;
    return {pixel->x, pixel->y, distance * projector.lens->depthOf(at / distance)};
  }
  const auto& k = camera.intrinsics;
  const double w = camera.orthographic ? 1 : at.z;
  if (!(w > 0)) return nullptr;
  return {(k[0] * at.x + k[1] * at.y) / w + k[2], (k[3] * at.x + k[4] * at.y) / w + k[5], at.z};
}

// Describes the oriented 3D box. The origin of its own frame is its center.
Json boxInSpace(const Object& object, const Projector& projector) {
  glm::dmat4 toWorld = object.toWorld;
  toWorld[3] = object.toWorld * glm::dvec4((object.low + object.high) * 0.5, 1);
  const glm::dmat4 fromWorld = openCvFromWorld(projector.camera);
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
  Extras needsExtras() const override { return {.boxes = true, .alone = whole_}; }

  FrameRecord writeFrame(const DataFrame& frame, const std::filesystem::path& folder) const override {
    const std::map<uint32_t, Mask> visible = masksOf(imageOf(frame.picture, output::Aov::Id));
    const Projector projector(frame.metadata.camera);
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
  static Json cameraOf(const output::CameraMetadata& camera) {
    Json json{{"K", camera.intrinsics}, {"worldToCamera", output::rowsOf(openCvFromWorld(camera))}};
    if (!camera.lens) return json;
    const scene::LensModelInfo& model = scene::infoOf(camera.lens->model);
    if (!model.calibrated) json["K"] = nullptr;
    json["model"] = model.name;
    json["distortion"] = output::distortionOf(*camera.lens);
    return json;
  }

  Json describe(const DataFrame& frame, const Projector& projector, const Object& object, const Mask* visible) const {
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
    }
    json["box"] = boxInSpace(object, projector);
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
