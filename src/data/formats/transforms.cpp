// The format "transforms": transforms.json of nerfstudio and instant-ngp, with pictures, depth and their cameras.
#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.h"
#include "data/cameras/shot.h"
#include "data/cameras/transforms.h"
#include "data/formats/camera_support.h"
#include "data/formats/depth_png.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"
#include "data/formats/sparse_points.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kStepsPerMetre = 1000;  // the default of nerfstudio

Json opticsOf(const DataFrame& frame) {
  if (frame.metadata.camera.lens) return transformsLens(*frame.metadata.camera.lens);
  const std::array<double, 9>& k = frame.metadata.camera.intrinsics;
  return {{"camera_model", "OPENCV"},
          {"fl_x", k[0]},
          {"fl_y", k[4]},
          {"cx", k[2]},
          {"cy", k[5]},
          {"w", frame.picture.width},
          {"h", frame.picture.height},
          {"k1", 0},
          {"k2", 0},
          {"p1", 0},
          {"p2", 0}};
}

bool isBending(const std::string& key) {
  return key == "camera_model" || key[0] == 'k' || key[0] == 'p';
}

// Returns the intrinsics that all frames share. The camera model and its distortion are either all included or all
// excluded, because nerfstudio reads them from one position.
Json commonOf(std::span<const Json> entries) {
  const auto bendingOf = [](const Json& entry) {
    Json some = Json::object();
    for (const auto& [key, value] : entry["optics"].items())
      if (isBending(key)) some[key] = value;
    return some;
  };
  Json common = Json::object();
  if (entries.empty()) return common;
  const bool sameDistortion =
      std::ranges::all_of(entries, [&](const Json& e) { return bendingOf(e) == bendingOf(entries[0]); });
  for (const auto& [key, value] : entries[0]["optics"].items()) {
    const auto same = [&](const Json& entry) { return entry["optics"].value(key, Json()) == value; };
    if (isBending(key) ? sameDistortion : std::ranges::all_of(entries, same)) common[key] = value;
  }
  return common;
}

// Returns the transform from OpenGL's camera frame (X right, Y up, Z backward) to the frame of the output `position`.
glm::dmat4 openGlPose(const output::CameraMetadata& camera) {
  return camera.convention == "opengl" ? camera.cameraToWorld : turnedAxes(camera.cameraToWorld);
}

class Transforms : public Format {
 public:
  explicit Transforms(const Json& json) {
    FormatOptions options("transforms", json);
    file_ = options.setFile("file", "transforms.json", ".json");
    picture_ = PictureFile(options);
    depth_ = options.flag("depth", true);
    depthFile_ = options.frameFile("depth-file", "depth/{name}.png", ".png");
    spacing_ = static_cast<uint32_t>(options.number("points", 0, 0, 4096));
    pointFile_ = options.setFile("point-file", "sparse_pc.ply", ".ply");
    options.finish();
    if (spacing_ > 0 && !depth_) badUsage("points of the format transforms are found by depth: remove depth: false");
  }

  std::vector<output::Aov> needs() const override {
    return depth_ ? std::vector{output::Aov::Depth} : std::vector<output::Aov>();
  }
  bool needsDisplay() const override { return picture_.isWritten(); }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files = picture_.files(frame);
    if (depth_) files.push_back({frameFile(depthFile_, frame), depthPngContents(output::Aov::Depth, kStepsPerMetre)});
    files.push_back({.name = file_, .ofSet = true});
    if (spacing_ > 0) files.push_back({.name = pointFile_, .ofSet = true});
    return files;
  }

  void check(const DataFrame& frame) const override {
    const output::CameraMetadata& camera = frame.metadata.camera;
    requirePerspective("transforms", camera);
    if (const std::string lack = camera.lens ? missingInTransforms(*camera.lens) : ""; !lack.empty())
      badUsage("the format transforms cannot express the camera \"{}\": {}", camera.name, lack);
    if (spacing_ > 0 && camera.lens && camera.lens->model == scene::LensModel::Equirectangular)
      badUsage("points of the format transforms require cameras with depth along an axis, not \"{}\"", camera.name);
  }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    const output::CameraMetadata& camera = frame.metadata.camera;
    const std::string depthFile = frameFile(depthFile_, frame);
    const std::string picture = picture_.write(record, frame, folder);
    record.entry["optics"] = opticsOf(frame);
    Json& entry = record.entry["frame"] = {{"file_path", picture}};
    if (depth_) {
      writeOf(record, folder, depthFile, encodeDepthPng(imageOf(frame.picture, output::Aov::Depth), kStepsPerMetre));
      entry["depth_file_path"] = depthFile;
    }
    entry["transform_matrix"] = output::rowsOf(openGlPose(camera));
    writeExposure(entry, frame.exposure);
    if (spacing_ > 0) {
      record.entry["state"] = {frame.scene, frame.variation};
      record.entry["view"] = describe(pointViewOf(frame));
    }
  }

  // Intrinsics that all cameras share are written once.
  std::vector<std::string> writeSet(const SetEntries& all, const std::filesystem::path& folder) const override {
    const std::span<const Json> entries = all.frames;
    const Json common = commonOf(entries);
    Json set = common;
    if (common.contains("fl_x") && common.contains("w") && common.value("camera_model", "") == "OPENCV")
      set["camera_angle_x"] = 2 * std::atan(common["w"].get<double>() / (2 * common["fl_x"].get<double>()));
    std::vector<std::string> written{file_};
    if (spacing_ > 0) {
      writeIn(folder, pointFile_, encodePly(pointsOf(entries, folder)));
      written.push_back(pointFile_);
      set["ply_file_path"] = pointFile_;
    }
    Json& frames = set["frames"] = Json::array();
    for (const Json& entry : entries) {
      Json& frame = frames.emplace_back(entry["frame"]);
      for (const auto& [key, value] : entry["optics"].items())
        if (!common.contains(key)) frame[key] = value;
    }
    writeJsonIn(folder, file_, set);
    return written;
  }

 private:
  // The points of each scene and variation, because others look different from the same cameras.
  std::vector<ColmapPoint> pointsOf(std::span<const Json> entries, const std::filesystem::path& folder) const {
    std::map<std::pair<uint32_t, uint32_t>, std::vector<const Json*>> states;
    for (const Json& entry : entries) states[{entry["state"][0], entry["state"][1]}].push_back(&entry);
    std::vector<ColmapPoint> all;
    for (const auto& [state, frames] : states) {
      std::vector<PointView> views;
      for (const Json* entry : frames) views.push_back(pointView((*entry)["view"]));
      const auto image = [&](size_t i, const char* key) {
        return output::readImage(folder / (*frames[i])["frame"][key].get<std::string>());
      };
      const auto depth = [&](size_t i) {
        const output::ReadImage steps = image(i, "depth_file_path");
        std::vector<float> meters;
        for (const double step : steps.channels.at(0).values)
          meters.push_back(static_cast<float>(step * 65535 / kStepsPerMetre));
        return meters;
      };
      std::vector<ColmapPoint> points =
          findSparsePoints(views, spacing_, depth, [&](size_t i) { return image(i, "file_path"); });
      all.insert(all.end(), std::make_move_iterator(points.begin()), std::make_move_iterator(points.end()));
    }
    return all;
  }

  std::string file_, depthFile_, pointFile_;
  uint32_t spacing_ = 0;  // pixels between points; 0: no points
  PictureFile picture_;
  bool depth_;
};

}  // namespace

std::unique_ptr<Format> makeTransforms(const Json& options) {
  return std::make_unique<Transforms>(options);
}

}  // namespace latelight::data
