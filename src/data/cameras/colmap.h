// Models of COLMAP: cameras and images, as text or binary files in a folder. Poses are those of its world; what it
// found in the pictures is skipped.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "data/cameras/calibrated.h"

namespace latelight::data {

// cameras.bin and images.bin, or where the first is missing the same as .txt. Throws Error(BadInput) that names the
// file and the line or the byte for what is broken, and for models of cameras that a lens can't hold.
std::vector<CalibratedCamera> readColmap(const std::filesystem::path& folder);
std::vector<CalibratedCamera> readColmapText(const std::filesystem::path& folder);
std::vector<CalibratedCamera> readColmapBinary(const std::filesystem::path& folder);

// Those two files and an empty points3D, which readers want. The same cameras, read again. Each needs a pinhole, OpenCV
// or fisheye lens; throws Error(Usage) without, and where a file can't be written. The folder must exist.
void writeColmapText(const std::filesystem::path& folder, std::span<const CalibratedCamera> cameras);
void writeColmapBinary(const std::filesystem::path& folder, std::span<const CalibratedCamera> cameras);

// --- what both have in common (colmap_models.cpp)
// ---------------------------------------------------------------------

struct ColmapModel {
  int id;  // in binary files
  std::string_view name;
  size_t parameters;
};
const ColmapModel* findColmapModel(int id);
const ColmapModel* findColmapModel(std::string_view name);

// Throws Error(BadInput) that begins with `where`.
scene::Lens lensOfColmap(const ColmapModel& model, double width, double height, std::span<const double> parameters,
                         const std::string& where);

struct ColmapCamera {
  const ColmapModel* model;
  std::vector<double> parameters;
};
ColmapCamera colmapCameraOf(const CalibratedCamera& camera);

// World to camera, as its files have it: a quaternion w x y z and a translation.
struct ColmapPose {
  glm::dvec4 rotation;
  glm::dvec3 translation;
};
ColmapPose colmapPoseOf(const glm::dmat4& pose);
glm::dmat4 poseOfColmap(const ColmapPose& pose, const std::string& where);

// Different lenses, and which one each camera has.
struct ColmapLenses {
  std::vector<const CalibratedCamera*> cameras;  // one for each lens
  std::vector<uint32_t> lensOf;                  // by camera
};
ColmapLenses differentLenses(std::span<const CalibratedCamera> cameras);

}  // namespace latelight::data
