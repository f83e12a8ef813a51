// transforms.json, as nerfstudio and instant-ngp read it: pictures with the cameras that made them.
#include <cmath>

#include "base/error.h"
#include "data/cameras/shot.h"
#include "data/formats/depth_png.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kStepsPerMetre = 1000;  // as nerfstudio reads depth unless told otherwise

Json opticsOf(const DataFrame& frame) {
  const std::array<double, 9>& k = frame.metadata.camera.intrinsics;
  return {{"fl_x", k[0]},
          {"fl_y", k[4]},
          {"cx", k[2]},
          {"cy", k[5]},
          {"w", frame.picture.width},
          {"h", frame.picture.height}};
}

// OpenGL's camera frame, X right, Y up, Z backward, to the frame of positions.
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
    options.finish();
  }

  std::vector<output::Aov> needs() const override {
    return depth_ ? std::vector{output::Aov::Depth} : std::vector<output::Aov>();
  }
  bool needsDisplay() const override { return picture_.isWritten(); }

  FrameRecord writeFrame(const DataFrame& frame, const std::filesystem::path& folder) const override {
    const output::CameraMetadata& camera = frame.metadata.camera;
    if (camera.orthographic)
      badUsage("the format transforms holds no orthographic camera, which \"{}\" is", camera.name);
    FrameRecord record;
    const std::string depthFile = frameFile(depthFile_, frame);
    const std::string picture = picture_.write(record, frame, folder);
    record.entry["optics"] = opticsOf(frame);
    Json& entry = record.entry["frame"] = {{"file_path", picture}};
    if (depth_) {
      writeOf(record, folder, depthFile, encodeDepthPng(imageOf(frame.picture, output::Aov::Depth), kStepsPerMetre));
      entry["depth_file_path"] = depthFile;
    }
    entry["transform_matrix"] = output::rowsOf(openGlPose(camera));
    return record;
  }

  // What all cameras have in common is said once.
  std::vector<std::string> writeSet(std::span<const Json> entries, const std::filesystem::path& folder) const override {
    const bool one = std::ranges::all_of(entries, [&](const Json& e) { return e["optics"] == entries[0]["optics"]; });
    Json set{{"camera_model", "OPENCV"}};
    if (one && !entries.empty()) {
      const Json& optics = entries[0]["optics"];
      set["camera_angle_x"] = 2 * std::atan(optics["w"].get<double>() / (2 * optics["fl_x"].get<double>()));
      set.update(optics);
    }
    for (const char* distortion : {"k1", "k2", "p1", "p2"}) set[distortion] = 0;
    Json& frames = set["frames"] = Json::array();
    for (const Json& entry : entries) {
      frames.push_back(entry["frame"]);
      if (!one) frames.back().update(entry["optics"]);
    }
    writeJsonBelow(folder, file_, set);
    return {file_};
  }

 private:
  std::string file_, depthFile_;
  PictureFile picture_;
  bool depth_;
};

}  // namespace

std::unique_ptr<Format> makeTransforms(const Json& options) {
  return std::make_unique<Transforms>(options);
}

}  // namespace latelight::data
