#include "data/cameras/calibrated.h"

#include <cmath>

#include "base/error.h"
#include "base/lowercase.h"
#include "data/cameras/optics.h"

namespace latelight::data {

using glm::dmat3, glm::dmat4, glm::dvec3, glm::dvec4;

namespace {

// Reads the transform from the file's world to the scene file's frame.
dmat4 readWorld(Spec& spec, const CameraContext& context) {
  const std::string axes = spec.choice("axes", {"scene", "y-up", "z-up"}, "scene");
  const double scale = spec.number("scale", kPositive, 1.0);
  dmat4 world(1);
  if (axes == "z-up" && context.scene.yUp) world = scene::toGltfFromWorld();
  if (axes == "y-up" && !context.scene.yUp) world = scene::toWorldFromGltf();
  for (int axis = 0; axis < 3; ++axis) world[axis] *= scale;
  return world;
}

}  // namespace

void CameraMemory::add(const CalibratedCamera& camera) {
  constexpr uint64_t kStep = uint64_t{1} << 20;
  bytes_ += 2 * sizeof(camera) + camera.name.size() + 32;
  for (; claimed_ < bytes_; claimed_ += kStep) claim_.grow(kStep, "the cameras of a file");
}

std::vector<Shot> placeCameras(Spec& spec, const CameraContext& context, const std::vector<CalibratedCamera>& cameras) {
  const dmat4 world = readWorld(spec, context);
  const bool lensless = std::ranges::all_of(cameras, [](const CalibratedCamera& camera) { return !camera.lens; });
  const Optics normal = lensless ? readOptics(spec, context.size) : Optics{};
  const PictureSize size = lensless ? PictureSize{normal.width, normal.height} : readSize(spec);
  scene::Camera own;
  if (!lensless) readAperture(spec, own);
  uint64_t names = 0;
  for (const CalibratedCamera& camera : cameras) names += camera.name.size();
  context.claim(spec, cameras.size(), names);
  std::vector<Shot> shots;
  for (const CalibratedCamera& camera : cameras) {
    dmat4 pose = world * camera.pose;
    for (int axis = 0; axis < 3; ++axis) pose[axis] = dvec4(glm::normalize(dvec3(pose[axis])), 0);
    Optics optics = normal;
    if (camera.lens && size.width) optics = opticsOf(*camera.lens, size.width, size.height);
    if (camera.lens && !size.width)
      optics =
          opticsOf(*camera.lens, static_cast<uint32_t>(camera.lens->width), static_cast<uint32_t>(camera.lens->height));
    if (camera.lens) optics.camera.aperture = own.aperture, optics.camera.focusDistance = own.focusDistance;
    shots.push_back({stemOf(camera.name), pose, optics.camera, optics.width, optics.height});
    shots.back().exposure = camera.exposure;
  }
  return shots;
}

dmat3 rotationOf(dvec4 q) {
  q /= glm::length(q);
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  return dmat3(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),  //
               2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),  //
               2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
}

// Starts from the largest component to preserve precision (Shepperd 1978, "Quaternion from rotation matrix").
dvec4 quaternionOf(const dmat3& r) {
  const double trace = r[0][0] + r[1][1] + r[2][2];
  const double squares[] = {trace, r[0][0], r[1][1], r[2][2]};
  const auto greatest = std::ranges::max_element(squares) - squares;
  dvec4 q;
  if (greatest == 0) {
    q = {1 + trace, r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]};
  } else {
    const int i = static_cast<int>(greatest) - 1, j = (i + 1) % 3, k = (i + 2) % 3;
    q[0] = r[j][k] - r[k][j];
    q[i + 1] = 1 + r[i][i] - r[j][j] - r[k][k];
    q[j + 1] = r[i][j] + r[j][i];
    q[k + 1] = r[i][k] + r[k][i];
  }
  q /= glm::length(q);
  return q[0] < 0 ? -q : q;
}

dmat4 inverseOf(const dmat4& pose) {
  const dmat3 back = glm::transpose(dmat3(pose));
  dmat4 inverse(back);
  inverse[3] = dvec4(-(back * dvec3(pose[3])), 1);
  return inverse;
}

void checkLens(const scene::Lens& lens, const std::string& where) {
  const auto isSide = [](double side) { return side >= 1 && side <= 65536 && side == std::floor(side); };
  if (!isSide(lens.width) || !isSide(lens.height))
    badInput("{} has an image of {} x {} pixels: width and height must be whole numbers from 1 to 65536", where,
             lens.width, lens.height);
  if (lens.model == scene::LensModel::Equirectangular) return;
  for (const double focal : {lens.fx, lens.fy})
    if (!(focal > 0) || !std::isfinite(focal))
      badInput("{} has a focal length of {}: it must be above 0", where, focal);
  bool finite = std::isfinite(lens.cx) && std::isfinite(lens.cy);
  for (const double term : lens.distortion) finite = finite && std::isfinite(term);
  if (!finite) badInput("{} has a principal point or distortion that is not finite", where);
}

std::string stemOf(const std::string& picture) {
  std::string_view stem = picture;
  while (stem.starts_with("./") || stem.starts_with("../")) stem.remove_prefix(stem.find('/') + 1);
  const size_t dot = stem.rfind('.');
  const size_t slash = stem.rfind('/');
  // Only extensions of picture formats are removed, because names may be times with a decimal point.
  constexpr std::string_view kEndings[] = {".png",  ".jpg",  ".jpeg", ".exr", ".tif",
                                           ".tiff", ".webp", ".bmp",  ".ppm", ".npy"};
  if (dot != stem.npos && (slash == stem.npos || dot > slash) &&
      std::ranges::find(kEndings, lowercase(std::string(stem.substr(dot)))) != std::end(kEndings))
    stem = stem.substr(0, dot);
  return std::string(stem);
}

}  // namespace latelight::data
