#include "data/cameras/transforms.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/text.h"
#include "data/cameras/json_file.h"
#include "output/metadata.h"
#include "scene/exact_math.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;
using scene::Lens, scene::LensModel;

namespace {

// The index of a key's term in Lens::distortion, by model. OpenCV's order is k1 k2 p1 p2 k3 k4 k5 k6.
struct Term {
  const char* key;
  size_t place;
};
constexpr Term kOpenCvTerms[] = {{"k1", 0}, {"k2", 1}, {"p1", 2}, {"p2", 3}, {"k3", 4}};
constexpr Term kFisheyeTerms[] = {{"k1", 0}, {"k2", 1}, {"k3", 2}, {"k4", 3}};
std::span<const Term> termsOf(LensModel model) {
  if (model == LensModel::OpenCv) return kOpenCvTerms;
  if (model == LensModel::Fisheye) return kFisheyeTerms;
  return {};
}

struct ModelName {
  LensModel model;
  const char* name;
};
constexpr ModelName kModelNames[] = {{LensModel::OpenCv, "OPENCV"},
                                     {LensModel::OpenCv, "SIMPLE_RADIAL"},
                                     {LensModel::OpenCv, "RADIAL"},
                                     {LensModel::Pinhole, "PINHOLE"},
                                     {LensModel::Pinhole, "SIMPLE_PINHOLE"},
                                     {LensModel::Fisheye, "OPENCV_FISHEYE"},
                                     {LensModel::Equirectangular, "EQUIRECTANGULAR"}};

LensModel modelIn(const Json& source, const std::string& where) {
  // Keys of instant-ngp.
  const auto fisheye = source.find("is_fisheye");
  if (fisheye != source.end() && *fisheye == true) return LensModel::Fisheye;
  if (source.contains("latlong")) return LensModel::Equirectangular;
  const auto model = source.find("camera_model");
  if (model == source.end()) return LensModel::OpenCv;
  const std::string name = model->is_string() ? model->get<std::string>() : model->dump();
  for (const ModelName& known : kModelNames)
    if (name == known.name) return known.model;
  std::vector<std::string> names;
  for (const ModelName& known : kModelNames) names.emplace_back(known.name);
  badInput("{} has the camera_model {}, which is not supported: give {}", where, name, joinedByOr(names));
}

// Returns a focal length in pixels, either from its key or from the angle of view that spans `pixels`; 0 if both keys
// are missing.
double focalIn(const Json& source, const char* key, const char* angleKey, double pixels, const std::string& where) {
  if (source.contains(key)) return numberIn(source, key, 0, where);
  const double angle = numberIn(source, angleKey, 0, where);
  if (angle == 0) return 0;
  if (!(angle > 0 && angle < exact::kPi)) badInput("{}: \"{}\" must be between 0 and pi", where, angleKey);
  return 0.5 * pixels * exact::cosine(angle / 2) / exact::sine(angle / 2);
}

Lens lensIn(const Json& source, PictureSize size, const std::string& where) {
  Lens lens{.model = modelIn(source, where)};
  lens.width = numberIn(source, "w", size.width, where), lens.height = numberIn(source, "h", size.height, where);
  if (lens.width == 0 || lens.height == 0)
    badInput("{} has no \"w\" and \"h\": give the size of its pictures as \"size\" here or among the job's options",
             where);
  if (lens.model != LensModel::Equirectangular) {
    lens.fx = focalIn(source, "fl_x", "camera_angle_x", lens.width, where);
    lens.fy = focalIn(source, "fl_y", "camera_angle_y", lens.height, where);
    constexpr const char* kKeys[] = {"fl_x", "fl_y", "camera_angle_x", "camera_angle_y"};
    if (std::ranges::none_of(kKeys, [&](const char* key) { return source.contains(key); }))
      badInput("{} has neither \"fl_x\" nor \"camera_angle_x\": give one of them", where);
    if (lens.fx == 0) lens.fx = lens.fy;
    if (lens.fy == 0) lens.fy = lens.fx;
    lens.cx = numberIn(source, "cx", lens.width / 2, where), lens.cy = numberIn(source, "cy", lens.height / 2, where);
  }
  bool distorted = false;
  for (const Term& term : termsOf(lens.model)) {
    lens.distortion[term.place] = numberIn(source, term.key, 0, where);
    distorted = distorted || lens.distortion[term.place] != 0;
  }
  if (lens.model == LensModel::OpenCv && numberIn(source, "k4", 0, where) != 0)
    badInput("{} has a k4 with the model OPENCV: there it is the coefficient of r^8, which OpenCV's lens does not have",
             where);
  if (lens.model == LensModel::OpenCv && !distorted) lens.model = LensModel::Pinhole;
  checkLens(lens, where);
  return lens;
}

// Merges a frame's intrinsics with those of the file; the frame has priority. Only keys of a lens are copied, because a
// file may have any other keys.
Json intrinsicsOf(const Json& all, const Json& frame) {
  Json merged = Json::object();
  for (const char* key : {"camera_model", "is_fisheye", "latlong", "w", "h", "fl_x", "fl_y", "camera_angle_x",
                          "camera_angle_y", "cx", "cy", "k1", "k2", "k3", "k4", "p1", "p2"})
    for (const Json* source : {&frame, &all})
      if (const auto found = source->find(key); found != source->end()) {
        merged[key] = *found;
        break;
      }
  return merged;
}

void checkWritable(const CalibratedCamera& camera, const std::filesystem::path& file) {
  const std::string lack = camera.lens ? missingInTransforms(*camera.lens) : "it has no lens";
  if (!lack.empty()) badUsage("{} cannot express the camera \"{}\": {}", file.string(), camera.name, lack);
}

}  // namespace

std::string missingInTransforms(const Lens& lens) {
  if (lens.model == LensModel::CubeMap) return "the format knows no cube maps";
  if (lens.model == LensModel::FTheta) return "the format knows no f-theta lenses";
  for (size_t term = 5; term < 8; ++term)
    if (lens.distortion[term] != 0) return "the format has no k4, k5 and k6 of OpenCV's distortion";
  return "";
}

Json transformsLens(const Lens& lens) {
  Json json = Json::object();
  for (const ModelName& known : kModelNames)
    if (known.model == lens.model && !json.contains("camera_model")) json["camera_model"] = known.name;
  const auto pixels = [](double n) { return n == std::floor(n) ? Json(static_cast<uint64_t>(n)) : Json(n); };
  json["w"] = pixels(lens.width), json["h"] = pixels(lens.height);
  if (lens.model == LensModel::Equirectangular) {
    // nerfstudio requires these keys; its images go from -1 to 1 across and from -1/2 to 1/2 down.
    json["fl_x"] = lens.width / 2, json["fl_y"] = lens.height, json["cx"] = lens.width / 2,
    json["cy"] = lens.height / 2;
    return json;
  }
  json["fl_x"] = lens.fx, json["fl_y"] = lens.fy, json["cx"] = lens.cx, json["cy"] = lens.cy;
  for (const Term& term : termsOf(lens.model)) json[term.key] = lens.distortion[term.place];
  return json;
}

std::vector<CalibratedCamera> readTransforms(const std::filesystem::path& file, PictureSize size) {
  const JsonDocument document = readJson(file);
  const Json& json = document.json;
  const auto frames = json.find("frames");
  if (!json.is_object() || frames == json.end() || !frames->is_array() || frames->empty())
    badInput("{} has no frames", file.string());
  const Json shared = intrinsicsOf(json, Json::object());
  const CameraExposure sharedExposure = exposureIn(json, file.string());
  std::vector<CalibratedCamera> cameras;
  CameraMemory memory;
  for (const Json& frame : *frames) {
    const std::string where = fmt::format("frame {} of {}", cameras.size(), file.string());
    if (!frame.is_object()) badInput("{} is no object", where);
    const std::vector<double> m = numbersIn(frame, "transform_matrix", 16, where);
    CalibratedCamera camera{.lens = lensIn(intrinsicsOf(shared, frame), size, where)};
    for (int i = 0; i < 16; ++i) camera.pose[i % 4][i / 4] = m[static_cast<size_t>(i)];
    if (!makeRigid(camera.pose)) badInput("{} has a transform_matrix that is no rotation and translation", where);
    camera.pose = turnedAxes(camera.pose);
    camera.exposure = combined(exposureIn(frame, where), sharedExposure);
    const auto picture = frame.find("file_path");
    if (picture != frame.end() && picture->is_string()) camera.name = picture->get<std::string>();
    memory.add(camera);
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

void writeTransforms(const std::filesystem::path& file, std::span<const CalibratedCamera> cameras) {
  for (const CalibratedCamera& camera : cameras) checkWritable(camera, file);
  const auto same = [&](const CalibratedCamera& camera) {
    return transformsLens(*camera.lens) == transformsLens(*cameras[0].lens);
  };
  const bool shared = !cameras.empty() && std::ranges::all_of(cameras, same);
  Json json = shared ? transformsLens(*cameras[0].lens) : Json::object();
  Json& frames = json["frames"] = Json::array();
  for (const CalibratedCamera& camera : cameras) {
    Json frame = shared ? Json::object() : transformsLens(*camera.lens);
    frame["file_path"] = camera.name;
    writeExposure(frame, camera.exposure);
    frame["transform_matrix"] = output::rowsOf(turnedAxes(camera.pose));
    frames.push_back(std::move(frame));
  }
  writeJson(file, json);
}

}  // namespace latelight::data
