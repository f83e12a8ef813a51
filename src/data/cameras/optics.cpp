#include "data/cameras/optics.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "scene/exact_math.h"
#include "scene/framing.h"

namespace latelight::data {

using scene::Lens, scene::LensModel;

namespace {

constexpr double kLongestSide = 65536;

// These functions round identically on every machine.
double arcTangent(double y, double x) {
  return exact::turnsOf(y, x) * exact::kTau;
}
double tangent(double angle) {
  return exact::sine(angle) / exact::cosine(angle);
}

// The angle at a distance from the principal point, below a right angle, as orbits require it.
double fthetaAngle(const Lens& lens, double r) {
  double angle = 0;
  for (size_t i = 6; i-- > 0;) angle = angle * r + lens.distortion[i];
  return std::clamp(angle, 0.0, 1.5);
}

float usableFov(double angle) {
  return std::clamp(static_cast<float>(angle), scene::kMinVerticalFov, scene::kMaxVerticalFov);
}

// Returns the key "fov" in radians.
double readAngle(Spec& spec) {
  constexpr double kNormal = 40, kDegree = exact::kPi / 180;
  return spec.number("fov", {1e-7, 179.999}, kNormal) * kDegree;
}

Optics opticsOfFov(Spec& spec) {
  const double angle = readAngle(spec);
  const PictureSize size = readSize(spec);
  Optics optics{.width = size.width, .height = size.height};
  optics.camera.verticalFov = usableFov(angle);
  const double aspect = size.height ? double(size.width) / size.height : 1;
  optics.halfAngle = arcTangent(tangent(angle / 2) * std::min(1.0, aspect), 1);
  return optics;
}

LensModel readModel(Spec& spec) {
  return scene::findLensModel(
             spec.choice("model", {"pinhole", "opencv", "fisheye", "equirectangular", "cubemap", "ftheta"}, "pinhole"))
      ->model;
}

void readMatrix(Spec& spec, Lens& lens) {
  const std::vector<double> k = spec.matrix("K", 3, 3);
  const bool upper = k[1] == 0 && k[3] == 0 && k[6] == 0 && k[7] == 0 && k[8] == 1;
  if (!upper || !(k[0] > 0) || !(k[4] > 0))
    badUsage("{} must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] with fx and fy above 0", spec.pathOf("K"));
  // The centers of pixels are at integers in OpenCV and at half-integers in Latelight.
  const double shift = 0.5 - spec.number("pixelCenter", {0, 0.5}, 0.5);
  lens.fx = k[0], lens.fy = k[4], lens.cx = k[2] + shift, lens.cy = k[5] + shift;
}

void readDistortion(Spec& spec, Lens& lens) {
  if (!spec.has("distortion")) return;
  const uint32_t coefficients = scene::infoOf(lens.model).coefficients;
  if (coefficients == 0) badUsage("{} needs the model opencv, fisheye or ftheta", spec.pathOf("distortion"));
  const std::vector<double> terms = spec.numbers("distortion", 1, coefficients);
  std::ranges::copy(terms, lens.distortion.begin());
}

}  // namespace

float readFov(Spec& spec) {
  return usableFov(readAngle(spec));
}

PictureSize readSize(Spec& spec, PictureSize normal) {
  if (!spec.has("size")) return normal;
  const std::vector<double> size = spec.numbers("size", 2, 2, {1, kLongestSide});
  if (size[0] != std::floor(size[0]) || size[1] != std::floor(size[1]))
    badUsage("{} must be whole numbers of pixels", spec.pathOf("size"));
  return {static_cast<uint32_t>(size[0]), static_cast<uint32_t>(size[1])};
}

Optics opticsOf(const Lens& lens, uint32_t width, uint32_t height) {
  Optics optics{.width = width, .height = height};
  if (!scene::infoOf(lens.model).calibrated) {
    optics.camera.lens = lens;
    return optics;
  }
  const double edges[] = {lens.cx / lens.fx, (lens.width - lens.cx) / lens.fx, lens.cy / lens.fy,
                          (lens.height - lens.cy) / lens.fy};
  const double edge = std::max(0.0, *std::ranges::min_element(edges));
  optics.halfAngle = lens.model == LensModel::FTheta ? fthetaAngle(lens, edge) : arcTangent(edge, 1);
  const bool sameShape = double(width) * lens.height == double(height) * lens.width;
  const double angle = 2 * arcTangent(lens.height / 2, lens.fy);
  const bool seen = scene::isUsableFieldOfView(static_cast<float>(angle));
  if (lens.model != LensModel::Pinhole || lens.fx != lens.fy || !sameShape || !seen) {
    optics.camera.lens = lens;
    return optics;
  }
  optics.camera.verticalFov = static_cast<float>(angle);
  optics.camera.principal = {static_cast<float>(2 * lens.cx / lens.width - 1),
                             static_cast<float>(1 - 2 * lens.cy / lens.height)};
  return optics;
}

namespace {

Optics readProjection(Spec& spec, PictureSize job) {
  const LensModel model = readModel(spec);
  Lens lens{.model = model};
  if (!spec.has("K") && model == LensModel::Pinhole) {
    readDistortion(spec, lens);  // reports the missing model
    if (spec.has("pixelCenter")) badUsage("{} needs \"K\"", spec.pathOf("pixelCenter"));
    return opticsOfFov(spec);
  }
  if (spec.has("fov")) badUsage("{} requires the model pinhole without K", spec.pathOf("fov"));
  const bool calibrated = scene::infoOf(model).calibrated;
  const PictureSize size = readSize(spec, calibrated ? job : PictureSize{});
  lens.width = size.width, lens.height = size.height;
  if (!calibrated) {
    if (spec.has("K")) badUsage("{} cannot be combined with the model {}", spec.pathOf("K"), spec.text("model"));
    // Panoramas have no intrinsics besides the aspect ratio, so any size with this ratio is valid.
    if (size.width == 0) lens.width = model == LensModel::CubeMap ? 6 : 2, lens.height = 1;
  } else {
    readMatrix(spec, lens);
    if (size.width == 0)
      badUsage("{} needs \"size\", here or among the job's options: the pixels that K counts in", spec.path());
  }
  readDistortion(spec, lens);
  return opticsOf(lens, size.width, size.height);
}

}  // namespace

void readAperture(Spec& spec, scene::Camera& camera) {
  if (spec.has("aperture")) camera.aperture = scene::parseAperture(spec.pathOf("aperture"), spec.text("aperture"));
  if (spec.has("focusDistance")) camera.focusDistance = spec.number("focusDistance", {1e-4, 1e9});
}

Optics readOptics(Spec& spec, PictureSize job) {
  Optics optics = readProjection(spec, job);
  readAperture(spec, optics.camera);
  return optics;
}

bool hasOptics(Spec& spec) {
  constexpr std::string_view kKeys[] = {"fov",  "K",           "model",    "distortion",
                                        "size", "pixelCenter", "aperture", "focusDistance"};
  return std::ranges::any_of(kKeys, [&](std::string_view key) { return spec.has(key); });
}

}  // namespace latelight::data
