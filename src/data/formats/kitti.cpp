// The format "kitti": images, labels and calibrations of KITTI's object benchmark (Geiger, Lenz and Urtasun 2012, "Are
// we ready for Autonomous Driving? The KITTI Vision Benchmark Suite"). Its boxes rotate only about the camera's y axis,
// as those of a level camera and of objects that stand upright do; other boxes are given by the rotation nearest to
// theirs, with the same center, length, height and width.
#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "data/formats/camera_support.h"
#include "data/formats/categories.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/geometry.h"
#include "data/formats/lidar_sensor.h"
#include "data/formats/names.h"
#include "data/formats/options.h"
#include "data/formats/picture_file.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;
using glm::dvec3;

// A box in the camera's frame (X right, Y down, Z forward).
struct UprightBox {
  dvec3 size;           // length along the object's front, height, width, in meters
  dvec3 bottom;         // the center of its lower face
  double rotation = 0;  // about y; 0: the front points along +X
};

// The axis of the object that is nearest to the camera's y becomes its height. Its front is z (glTF 2.0, 3.4), or x if
// z is the height, as for robots (ROS REP 103).
UprightBox uprightOf(const Object& object, const glm::dmat4& cameraFromWorld) {
  const glm::dmat4 toCamera = cameraFromWorld * object.toWorld;
  const dvec3 extent = object.high - object.low;
  const auto down = [&](int axis) { return std::abs(toCamera[axis].y); };
  int up = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (down(axis) > down(up)) up = axis;
  const int front = up == 2 ? 0 : 2, side = 3 - up - front;
  UprightBox box{.size = {extent[front], extent[up], extent[side]}};
  box.bottom = dvec3(toCamera * glm::dvec4((object.low + object.high) * 0.5, 1)) + dvec3(0, extent[up] / 2, 0);
  box.rotation = std::atan2(-toCamera[front].z, toCamera[front].x);
  return box;
}

// The angle in [-pi, pi).
double wrapped(double angle) {
  return angle - 2 * M_PI * std::floor((angle + M_PI) / (2 * M_PI));
}

class Kitti : public Format {
 public:
  explicit Kitti(const Json& json) : Kitti(json, FormatOptions("kitti", json)) {}

  std::vector<output::Aov> needs() const override { return {output::Aov::Id}; }
  bool needsDisplay() const override { return picture_.isWritten(); }
  Extras needsExtras() const override { return {.boxes = true, .alone = true}; }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    std::vector<FormatFile> files = picture_.files(frame);
    files.push_back({frameFile(labels_, frame)});
    files.push_back({frameFile(calibrations_, frame), "KITTI's calibration"});
    return files;
  }

  void check(const DataFrame& frame) const override { requirePinhole("kitti", frame.metadata.camera); }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    picture_.write(record, frame, folder);
    const std::map<uint32_t, Mask> masks = masksOf(imageOf(frame.picture, output::Aov::Id));
    const glm::dmat4 cameraFromWorld = openCvFromWorld(frame.metadata.camera);
    std::string text;
    uint64_t count = 0;
    for (const Object& object : frame.objects) {
      const auto mask = masks.find(object.id);
      const std::string category = mask != masks.end() ? categories_.of(object.id, *frame.metadata.ids) : "";
      if (category.empty()) continue;
      ++count;
      text += describe(asWord(category), object, mask->second, uprightOf(object, cameraFromWorld));
    }
    writeOf(record, folder, frameFile(labels_, frame), std::as_bytes(std::span(text)));
    const std::string calibration = calibrationOf(frame);
    writeOf(record, folder, frameFile(calibrations_, frame), std::as_bytes(std::span(calibration)));
    record.entry = count;
  }

  std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const override {
    categories_.warnIfUnused(std::vector<uint64_t>(set.frames.begin(), set.frames.end()));
    return {};
  }

 private:
  Kitti(const Json& json, FormatOptions options) : categories_("kitti", options.find("categories")) {
    labels_ = options.frameFile("labels", "label_2/{name}.txt", ".txt");
    calibrations_ = options.frameFile("calibrations", "calib/{name}.txt", ".txt");
    picture_ = PictureFile(options, "image_2/{name}.png");
    options.finish();
  }

  // Occlusion has three levels, which KITTI does not measure: here at least 80 %, at least 40 % or less of the object's
  // pixels in the picture are visible.
  static std::string describe(const std::string& category, const Object& object, const Mask& mask,
                              const UprightBox& box) {
    const double inPicture = double(object.alone.area());
    const double truncation = object.pixels > 0 ? 1 - inPicture / double(object.pixels) : 0;
    const double visible = inPicture > 0 ? double(mask.area()) / inPicture : 1;
    const PixelBox pixels = mask.box();
    const double alpha = wrapped(box.rotation - std::atan2(box.bottom.x, box.bottom.z));
    return fmt::format("{} {:.2f} {} {:.6f} {} {} {} {} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f}\n", category,
                       truncation,
                       visible >= 0.8   ? 0
                       : visible >= 0.4 ? 1
                                        : 2,
                       alpha, pixels.x, pixels.y, pixels.x + pixels.width - 1, pixels.y + pixels.height - 1, box.size.y,
                       box.size.z, box.size.x, box.bottom.x, box.bottom.y, box.bottom.z, box.rotation);
  }

  // KITTI's centers of pixels are whole numbers, which moves the principal point by half a pixel.
  static std::string calibrationOf(const DataFrame& frame) {
    const std::array<double, 9>& k = frame.metadata.camera.intrinsics;
    const std::string camera =
        fmt::format("{:.9g} 0 {:.9g} 0 0 {:.9g} {:.9g} 0 0 0 1 0", k[0], k[2] - 0.5, k[4], k[5] - 0.5);
    std::string text;
    for (int i = 0; i < 4; ++i) text += fmt::format("P{}: {}\n", i, camera);
    text += "R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam:";
    const glm::dmat4 cameraFromLidar = cameraFromLidarOf(frame);
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) text += fmt::format(" {:.9g}", cameraFromLidar[column][row] + 0.0);
    return text + "\nTr_imu_to_velo: 1 0 0 0 0 1 0 0 0 0 1 0\n";
  }

  // The mount of the job's first lidar. If the job has none, KITTI's axes at the camera's position.
  static glm::dmat4 cameraFromLidarOf(const DataFrame& frame) {
    return frame.scans.empty() ? cameraFromSensorAxes() : frame.scans.front().request->cameraFromSensor;
  }

  Categories categories_;
  std::string labels_, calibrations_;
  PictureFile picture_;
};

}  // namespace

std::unique_ptr<Format> makeKitti(const Json& options) {
  return std::make_unique<Kitti>(options);
}

}  // namespace latelight::data
