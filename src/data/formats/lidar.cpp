// The format "lidar": the point clouds of a lidar sensor on each camera, as PLY, PCD, KITTI's .bin or NPZ.
#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "base/hash.h"
#include "data/cameras/pose_spec.h"
#include "data/formats/categories.h"
#include "data/formats/formats.h"
#include "data/formats/frame_files.h"
#include "data/formats/lidar_sensor.h"
#include "data/formats/names.h"
#include "data/formats/options.h"
#include "data/json_text.h"
#include "output/metadata.h"
#include "output/points.h"

namespace latelight::data {

namespace {

using Json = nlohmann::ordered_json;

constexpr uint32_t kSlices = 10;

// Reads the sensor's pose on the camera, in OpenCV's camera frame, as for the members of a rig.
glm::dmat4 readMount(const Json& value) {
  Spec spec(value, "mount");
  glm::dmat4 pose(1);
  if (spec.has("pose"))
    pose = readPoseMatrix(spec);
  else
    pose[3] = glm::dvec4(spec.vector("translation"), 1);
  spec.finish();
  return pose * cameraFromSensorAxes();
}

uint32_t readCount(FormatOptions& options, std::string_view key, uint32_t preset, uint32_t most) {
  const double count = options.number(key, preset, 1, most);
  if (count != std::floor(count)) badUsage("{} of the format lidar takes a whole number, not {}", key, count);
  return static_cast<uint32_t>(count);
}

class Lidar : public Format {
 public:
  explicit Lidar(const Json& json) : Lidar(json, FormatOptions("lidar", json)) {}

  std::vector<output::Aov> needs() const override { return {}; }
  Extras needsExtras() const override { return {.scans = {request_}}; }
  std::vector<FormatFile> files(const DataFrame& frame) const override {
    return {{frameFile(file_, frame)}, {.name = list_, .ofSet = true}};
  }

  void writeFiles(const DataFrame& frame, const std::filesystem::path& folder, FrameRecord& record) const override {
    for (const FrameScan& scan : frame.scans) {
      if (scan.request->key != request_->key) continue;
      const std::string file = frameFile(file_, frame);
      std::vector<float> buffer;
      writeOf(record, folder, file, output::encodePoints(as_, lidar::fieldsOf(scan.points, world_, buffer)));
      record.entry = {{"name", frame.name},
                      {"file", file},
                      {"points", scan.points.size()},
                      {"time", scan.start ? Json(*scan.start) : Json()},
                      {"world_from_sensor", output::rowsOf(scan.worldFromSensor)},
                      {"objects", objectsOf(scan.points, *frame.metadata.ids)}};
    }
  }

  std::vector<std::string> writeSet(const SetEntries& set, const std::filesystem::path& folder) const override {
    const std::span<const Json> entries = set.frames;
    Json scans = Json::array();
    for (const Json& entry : entries) scans.push_back(entry);
    writeJsonIn(folder, list_,
                {{"sensor", request_->sensor.name},
                 {"period", 1 / request_->sensor.rate},
                 {"camera_from_sensor", output::rowsOf(request_->cameraFromSensor)},
                 {"scans", scans}});
    return {list_};
  }

 private:
  Lidar(const Json& json, FormatOptions options) : categories_("lidar", options.find("categories")) {
    const auto request = std::make_shared<ScanRequest>();
    const Json* sensor = options.find("sensor");
    if (!sensor) badUsage("the format lidar needs a \"sensor\": the name of one, or an object with its \"type\"");
    request->sensor = readSensor(*sensor);
    const lidar::Pattern pattern = lidar::patternOf(request->sensor);
    request->seconds = std::max(pattern.period, std::ranges::max(pattern.times));
    request->options.samples = readCount(options, "samples", 1, lidar::kMaxRaysOfBeam);
    request->options.slices = readCount(options, "slices", kSlices, lidar::kMaxSlices);
    request->options.returns = lidar::returnsNamed(options.text("returns", "strongest"));
    const Json* mount = options.find("mount");
    request->cameraFromSensor = mount ? readMount(*mount) : cameraFromSensorAxes();
    const Json where = {*sensor, mount ? *mount : Json()};
    request->noiseStream = hash64(dumped(where).data(), dumped(where).size());
    request->key = dumped({where, request->options.samples, request->options.slices, request->options.returns});
    as_ = options.choice("as", {"ply", "pcd", "bin", "npz"});
    world_ = options.choice("frame", {"sensor", "world"}) == "world";
    file_ = options.frameFile("file", "lidar/{name}." + as_, "." + as_);
    list_ = options.setFile("scans", "lidar/scans.json", ".json");
    options.finish();
    request_ = request;
  }

  // The objects of the points, by id.
  Json objectsOf(const lidar::Points& points, const output::IdManifest& ids) const {
    Json objects = Json::array();
    for (const uint32_t id : std::set<uint32_t>(points.id.begin(), points.id.end()))
      if (const output::IdEntry* entry = entryOf(ids, id))
        objects.push_back({{"id", id}, {"node", nameOf(*entry)}, {"category", categories_.of(id, ids)}});
    return objects;
  }

  Categories categories_;
  std::shared_ptr<const ScanRequest> request_;
  std::string as_, file_, list_;
  bool world_ = false;
};

}  // namespace

std::unique_ptr<Format> makeLidar(const Json& options) {
  return std::make_unique<Lidar>(options);
}

}  // namespace latelight::data
