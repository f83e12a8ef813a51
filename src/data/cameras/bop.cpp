#include "data/cameras/bop.h"

#include <fmt/format.h>

#include <map>

#include "base/error.h"
#include "base/text.h"
#include "data/cameras/json_file.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

constexpr double kMillimeter = 1e-3;
constexpr double kFirstCenter = 0.5;  // center of the first pixel; in BOP, as in OpenCV, it is 0

CalibratedCamera cameraIn(const Json& entry, const std::string& name, PictureSize size, const std::string& where) {
  const std::vector<double> k = numbersIn(entry, "cam_K", 9, where), r = numbersIn(entry, "cam_R_w2c", 9, where),
                            t = numbersIn(entry, "cam_t_w2c", 3, where);
  if (k[1] != 0) badInput("{} has a cam_K with skew, which is not supported", where);
  CalibratedCamera camera{.name = name, .exposure = exposureIn(entry, where)};
  camera.lens = scene::Lens{.width = double(size.width),
                            .height = double(size.height),
                            .fx = k[0],
                            .fy = k[4],
                            .cx = k[2] + kFirstCenter,
                            .cy = k[5] + kFirstCenter};
  checkLens(*camera.lens, where);
  glm::dmat4 toCamera(1);
  for (int i = 0; i < 9; ++i) toCamera[i % 3][i / 3] = r[static_cast<size_t>(i)];
  toCamera[3] = glm::dvec4(glm::dvec3(t[0], t[1], t[2]) * kMillimeter, 1);
  if (!makeRigid(toCamera)) badInput("{} has a cam_R_w2c that is not a rotation", where);
  camera.pose = inverseOf(toCamera);
  return camera;
}

}  // namespace

std::vector<CalibratedCamera> readBop(const std::filesystem::path& file, PictureSize size) {
  const JsonDocument document = readJson(file);
  const Json& json = document.json;
  if (!json.is_object() || json.empty()) badInput("{} has no pictures", file.string());
  std::map<uint64_t, CalibratedCamera> byNumber;
  CameraMemory memory;
  for (const auto& [key, entry] : json.items()) {
    const std::string where = fmt::format("picture {} of {}", shortened(key), file.string());
    const std::optional<uint64_t> number = parseNumber<uint64_t>(key);
    if (!number) badInput("{} has a name that is no whole number", where);
    if (!entry.is_object()) badInput("{} is no object", where);
    CalibratedCamera camera = cameraIn(entry, key, size, where);
    memory.add(camera);
    byNumber.insert_or_assign(*number, std::move(camera));
  }
  std::vector<CalibratedCamera> cameras;
  for (auto& [number, camera] : byNumber) cameras.push_back(std::move(camera));
  return cameras;
}

void writeBop(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras, double depthScale) {
  Json json = Json::object();
  for (const CalibratedCamera& camera : cameras) {
    if (!camera.lens || camera.lens->model != scene::LensModel::Pinhole || !parseNumber<uint64_t>(camera.name))
      badUsage("scene_camera.json cannot express the camera \"{}\": it requires a pinhole lens and a numeric name",
               camera.name);
    const glm::dmat4 toCamera = inverseOf(camera.pose);
    Json& entry = json[camera.name] = Json::object();
    const scene::Lens& lens = *camera.lens;
    entry["cam_K"] = {lens.fx, 0.0, lens.cx - kFirstCenter, 0.0, lens.fy, lens.cy - kFirstCenter, 0.0, 0.0, 1.0};
    entry["cam_R_w2c"] = Json::array();
    entry["cam_t_w2c"] = Json::array();
    for (int i = 0; i < 9; ++i) entry["cam_R_w2c"].push_back(toCamera[i % 3][i / 3]);
    for (int i = 0; i < 3; ++i) entry["cam_t_w2c"].push_back(toCamera[3][i] / kMillimeter);
    entry["depth_scale"] = depthScale;
    writeExposure(entry, camera.exposure);
  }
  writeJson(file, json);
}

}  // namespace latelight::data
