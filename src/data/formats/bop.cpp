// The format "bop", the layout of the Benchmark for 6D Object Pose Estimation (BOP). Each scene has a folder with
// pictures, depth, visible and amodal masks, and the poses of objects and cameras, in millimeters. models_info.json
// lists the models of the whole set.
#include <fmt/format.h>

#include <map>

#include "base/error.h"
#include "data/formats/bop_models.h"
#include "data/formats/camera_support.h"
#include "data/formats/depth_png.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/geometry.h"
#include "data/formats/names.h"
#include "data/formats/options.h"
#include "data/formats/shape_json.h"
#include "output/png.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kMillimetres = 1000;  // per meter

// Folders of amodal and of visible masks, and files, below the folder of a scene.
constexpr const char* kMasks[] = {"mask", "mask_visib"};
constexpr const char *kCameras = "/scene_camera.json", *kPoses = "/scene_gt.json", *kInfos = "/scene_gt_info.json";
// Files of the set.
constexpr const char *kModelInfo = "models/models_info.json", *kModelList = "models/models.json";

Json bopRotation(const glm::dmat4& m) {
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) rows.push_back(m[column][row]);
  return rows;
}

Json bopTranslation(const glm::dmat4& m) {
  return {m[3].x * kMillimetres, m[3].y * kMillimetres, m[3].z * kMillimetres};
}

Json bopBox(const PixelBox& box) {
  if (box.width == 0) return {-1, -1, -1, -1};
  return {box.x, box.y, box.width, box.height};
}

std::vector<std::byte> opaquePng(const output::FrameOutput& picture) {
  const std::vector<uint8_t> rgb = rgbOverBlack(picture);
  return output::encodePng(picture.width, picture.height, 3, 8, reinterpret_cast<const std::byte*>(rgb.data()),
                           output::PngLight::Srgb);
}

std::vector<std::byte> maskPng(const Mask& mask) {
  const std::vector<uint8_t> pixels = mask.pixels();
  return output::encodePng(mask.width, mask.height, 1, 8, reinterpret_cast<const std::byte*>(pixels.data()),
                           output::PngLight::Data);
}

class Bop : public Format {
 public:
  explicit Bop(const Json& json) {
    FormatOptions options("bop", json);
    split_ = options.setFolder("split", "train");
    depthScale_ = options.number("depth-scale", 1, 1e-3, 1e4);
    numbers_ = BopNumbers(options.find("models"));
    options.finish();
  }

  std::vector<output::Aov> needs() const override { return {output::Aov::Id, output::Aov::Depth}; }
  bool needsDisplay() const override { return true; }
  Extras needsExtras() const override { return {.boxes = true, .alone = true, .shapes = true}; }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    const std::string scene = sceneFolder(frame.scene);
    std::vector<FormatFile> files{{imageFile(frame, "rgb")}, {imageFile(frame, "depth")}};
    // The number of masks is known only after the frame is rendered.
    for (const char* kind : kMasks) files.push_back({.name = fmt::format("{}/{}/", scene, kind), .ofSet = true});
    for (const char* name : {kCameras, kPoses, kInfos}) files.push_back({.name = scene + name, .ofSet = true});
    for (const char* name : {kModelInfo, kModelList}) files.push_back({.name = name, .ofSet = true});
    return files;
  }

  void check(const DataFrame& frame) const override { requirePinhole("bop", frame.metadata.camera); }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    const output::AovImage& depth = imageOf(frame.picture, output::Aov::Depth);
    const double stepsPerMetre = kMillimetres / depthScale_;
    const std::string scene = sceneFolder(frame.scene);
    writeOf(record, folder, imageFile(frame, "rgb"), opaquePng(frame.picture));
    writeOf(record, folder, imageFile(frame, "depth"), encodeDepthPng(depth, stepsPerMetre));
    const std::vector<uint16_t> steps = depthSteps(depth, stepsPerMetre);
    std::map<uint32_t, Mask> visible = masksOf(imageOf(frame.picture, output::Aov::Id));
    Json objects = Json::array();
    for (const Object& object : frame.objects) {
      if (object.alone.area() == 0 || !numbers_.takes(nodeOf(frame, object))) continue;
      Mask& seen = visible[object.id];
      if (seen.runs.empty()) seen = {depth.width, depth.height, {depth.width * depth.height}};
      for (const auto& [kind, mask] : {std::pair(kMasks[0], &object.alone), std::pair(kMasks[1], &std::as_const(seen))})
        writeOf(record, folder, fmt::format("{}/{}/{:06}_{:06}.png", scene, kind, frame.index, objects.size()),
                maskPng(*mask));
      objects.push_back(describe(frame, object, seen, steps));
    }
    record.entry = {
        {"scene", frame.scene}, {"image", frame.index}, {"camera", cameraOf(frame)}, {"objects", std::move(objects)}};
  }

  std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const override {
    const std::span<const Json> entries = set.frames;
    BopModels models(numbers_);
    for (const Json& entry : entries)
      for (const Json& object : entry["objects"]) models.add(object);
    models.number();
    std::map<std::string, Json> files;
    const auto fileOf = [&](const std::string& name) -> Json& {
      return files.try_emplace(name, Json::object()).first->second;
    };
    for (const Json& entry : entries) {
      const std::string scene = sceneFolder(entry["scene"].get<uint32_t>());
      const std::string image = std::to_string(entry["image"].get<uint64_t>());
      fileOf(scene + kCameras)[image] = entry["camera"];
      Json& poses = fileOf(scene + kPoses)[image] = Json::array();
      Json& infos = fileOf(scene + kInfos)[image] = Json::array();
      for (const Json& object : entry["objects"]) {
        Json pose = object["pose"];
        pose["obj_id"] = models.numberOf(object);
        poses.push_back(std::move(pose));
        infos.push_back(object["info"]);
      }
    }
    files[kModelInfo] = models.info();
    files[kModelList] = models.list();
    std::vector<std::string> written;
    for (const auto& [name, json] : files) {
      writeJsonIn(folder, name, json);
      written.push_back(name);
    }
    return written;
  }

 private:
  std::string sceneFolder(uint32_t scene) const { return fmt::format("{}/{:06}", split_, scene); }

  std::string imageFile(const DataFrame& frame, const char* kind) const {
    return fmt::format("{}/{}/{:06}.png", sceneFolder(frame.scene), kind, frame.index);
  }

  // In BOP, as in OpenCV, the center of the first pixel is (0, 0).
  Json cameraOf(const DataFrame& frame) const {
    std::array<double, 9> k = frame.metadata.camera.intrinsics;
    k[2] -= 0.5;
    k[5] -= 0.5;
    const glm::dmat4 fromWorld = openCvFromWorld(frame.metadata.camera);
    Json entry = {{"cam_K", k},
                  {"depth_scale", depthScale_},
                  {"cam_R_w2c", bopRotation(fromWorld)},
                  {"cam_t_w2c", bopTranslation(fromWorld)}};
    writeExposure(entry, frame.exposure);
    return entry;
  }

  static std::string nodeOf(const DataFrame& frame, const Object& object) {
    const output::IdEntry* entry = entryOf(*frame.metadata.ids, object.id);
    return entry ? nameOf(*entry) : std::to_string(object.id);
  }

  static Json describe(const DataFrame& frame, const Object& object, const Mask& visible,
                       const std::vector<uint16_t>& steps) {
    const std::vector<uint8_t> alone = object.alone.pixels();
    uint64_t valid = 0;
    for (size_t i = 0; i < alone.size(); ++i) valid += alone[i] != 0 && steps[i] != 0;
    const uint64_t pixels = visible.area();
    const glm::dmat4 toCamera = openCvFromWorld(frame.metadata.camera) * object.toWorld;
    const output::IdEntry* entry = entryOf(*frame.metadata.ids, object.id);
    const std::string node = nodeOf(frame, object), name = !entry || entry->mesh.empty() ? node : entry->mesh;
    const glm::dvec3 low = object.low * kMillimetres, size = (object.high - object.low) * kMillimetres;
    return {{"node", node},
            {"name", name},
            {"shape", describeShape(object.shape)},
            {"modelInfo",
             {{"min_x", low.x},
              {"min_y", low.y},
              {"min_z", low.z},
              {"size_x", size.x},
              {"size_y", size.y},
              {"size_z", size.z},
              {"name", name}}},
            {"pose", {{"cam_R_m2c", bopRotation(toCamera)}, {"cam_t_m2c", bopTranslation(toCamera)}}},
            {"info",
             {{"bbox_obj", bopBox(object.full)},
              {"bbox_visib", bopBox(visible.box())},
              {"px_count_all", object.pixels},
              {"px_count_valid", valid},
              {"px_count_visib", pixels},
              {"visib_fract", static_cast<double>(pixels) / static_cast<double>(object.pixels)}}}};
  }

  std::string split_;
  double depthScale_;
  BopNumbers numbers_{nullptr};
};

}  // namespace

std::unique_ptr<Format> makeBop(const Json& options) {
  return std::make_unique<Bop>(options);
}

}  // namespace latelight::data
