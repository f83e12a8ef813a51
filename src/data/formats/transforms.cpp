// The format "transforms": transforms.json of nerfstudio and instant-ngp, with pictures, depth and their cameras.
#include <fmt/format.h>

#include <algorithm>
#include <array>
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
  if (const auto& lens = frame.metadata.camera.lens) {
    Json optics = transformsLens(*lens);
    // instant-ngp does not read the model. Its "equirectangular" is another, equal-area projection.
    if (lens->model == scene::LensModel::Fisheye) optics["is_fisheye"] = true;
    if (lens->model == scene::LensModel::Equirectangular) optics["latlong"] = true;
    return optics;
  }
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

// Readers find the keys of a group in one object: nerfstudio reads the model only of all frames, and the distortion
// either of all frames or per frame; instant-ngp combines each of the other groups only within an object.
constexpr int kGroups = 4;
int groupOf(const std::string& key) {
  if (key == "camera_model" || key == "latlong") return 0;
  if (key == "fl_x" || key == "fl_y") return 1;
  if (key == "cx" || key == "cy" || key == "w" || key == "h") return 2;
  return 3;  // is_fisheye, k1 to k4, p1 and p2
}

// Returns the intrinsics that all frames share: groups with equal values in all of them.
Json commonOf(std::span<const Json* const> entries) {
  const auto groupIn = [](const Json& entry, int group) {
    Json part = Json::object();
    for (const auto& [key, value] : entry["optics"].items())
      if (groupOf(key) == group) part[key] = value;
    return part;
  };
  std::array<bool, kGroups> isShared{};
  for (int group = 0; group < kGroups; ++group) {
    const Json first = groupIn(*entries.front(), group);
    isShared[static_cast<size_t>(group)] =
        std::ranges::all_of(entries, [&](const Json* entry) { return groupIn(*entry, group) == first; });
  }
  Json common = Json::object();
  for (const auto& [key, value] : (*entries.front())["optics"].items())
    if (isShared[static_cast<size_t>(groupOf(key))]) common[key] = value;
  return common;
}

// Returns the name of the file of the scene and variation with this number: a.json, a-1.json, a-2.json.
std::string numbered(const std::string& file, uint64_t number) {
  if (number == 0) return file;
  const size_t dot = file.rfind('.');
  return fmt::format("{}-{}{}", file.substr(0, dot), number, file.substr(dot));
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
    files.push_back({.name = numbered(file_, frame.state), .ofSet = true});
    if (spacing_ > 0) files.push_back({.name = numbered(pointFile_, frame.state), .ofSet = true});
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

  void checkTogether(const DataFrame& first, const DataFrame& other) const override {
    const std::string a = opticsOf(first)["camera_model"], b = opticsOf(other)["camera_model"];
    if (a != b)
      badUsage(
          "the format transforms has one camera_model for all frames, but that of the camera \"{}\" is {} and that of "
          "\"{}\" is {}: choose cameras of one model, or render two data sets",
          first.metadata.camera.name, a, other.metadata.camera.name, b);
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
    record.entry["state"] = {frame.scene, frame.variation};
    if (spacing_ > 0) record.entry["view"] = describe(pointViewOf(frame));
  }

  // Writes a file per scene and variation, because others look different from the same cameras.
  std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const override {
    std::map<std::pair<uint32_t, uint32_t>, std::vector<const Json*>> states;
    for (const Json& entry : set.frames) states[{entry["state"][0], entry["state"][1]}].push_back(&entry);
    std::vector<std::string> written;
    uint64_t number = 0;
    for (const auto& [state, entries] : states) {
      const std::string pointFile = spacing_ > 0 ? numbered(pointFile_, number) : "";
      if (spacing_ > 0) {
        writeIn(folder, pointFile, encodePly(pointsOf(entries, folder)));
        written.push_back(pointFile);
      }
      written.push_back(numbered(file_, number++));
      writeJsonIn(folder, written.back(), describeFrames(entries, pointFile));
    }
    return written;
  }

 private:
  static Json describeFrames(std::span<const Json* const> entries, const std::string& pointFile) {
    const Json common = commonOf(entries);
    Json set = common;
    if (common.contains("fl_x") && common.contains("w") && common.value("camera_model", "") == "OPENCV")
      set["camera_angle_x"] = 2 * std::atan(common["w"].get<double>() / (2 * common["fl_x"].get<double>()));
    if (!pointFile.empty()) set["ply_file_path"] = pointFile;
    Json& frames = set["frames"] = Json::array();
    for (const Json* entry : entries) {
      Json& frame = frames.emplace_back((*entry)["frame"]);
      for (const auto& [key, value] : (*entry)["optics"].items())
        if (!common.contains(key)) frame[key] = value;
    }
    return set;
  }

  std::vector<ColmapPoint> pointsOf(std::span<const Json* const> entries, const std::filesystem::path& folder) const {
    std::vector<PointView> views;
    for (const Json* entry : entries) views.push_back(pointView((*entry)["view"]));
    const auto image = [&](size_t i, const char* key) {
      return output::readImage(folder / (*entries[i])["frame"][key].get<std::string>());
    };
    const auto depth = [&](size_t i) {
      const output::ReadImage steps = image(i, "depth_file_path");
      std::vector<float> meters;
      for (const double step : steps.channels.at(0).values)
        meters.push_back(static_cast<float>(step * 65535 / kStepsPerMetre));
      return meters;
    };
    return findSparsePoints(views, spacing_, depth, [&](size_t i) { return image(i, "file_path"); });
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
