// Reads and writes COLMAP models: the cameras and images, as text or binary files in a folder. Poses are in the model's
// world. Readers skip the model's image features and points.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "data/cameras/calibrated.h"

namespace latelight::data {

// Reads cameras.bin and images.bin, or cameras.txt and images.txt if cameras.bin is missing. Throws Error(BadInput) for
// invalid files and for camera models that a scene::Lens can't represent; the message names the file and the line or
// byte.
std::vector<CalibratedCamera> readColmap(const std::filesystem::path& folder);
std::vector<CalibratedCamera> readColmapText(const std::filesystem::path& folder);
std::vector<CalibratedCamera> readColmapBinary(const std::filesystem::path& folder);

// A point of a model and the images that show it.
struct ColmapObservation {
  uint32_t image = 0;   // index of the camera
  glm::dvec2 pixel{0};  // pixel centers are at half-integers
};
struct ColmapPoint {
  glm::dvec3 position{0};
  std::array<uint8_t, 3> color{};  // sRGB
  std::vector<ColmapObservation> track;
};

// Write the cameras, images and points3D files so that readers return the same cameras. The folder must exist. Throw
// Error(Usage) if a camera lacks a pinhole, OpenCV or fisheye lens, and if a file cannot be written.
void writeColmapText(const std::filesystem::path& folder, std::span<const CalibratedCamera> cameras,
                     std::span<const ColmapPoint> points = {});
void writeColmapBinary(const std::filesystem::path& folder, std::span<const CalibratedCamera> cameras,
                       std::span<const ColmapPoint> points = {});

// --- common to text and binary files (colmap_models.cpp) ------------------------------------------------------------

struct ColmapModel {
  int id;  // the number in binary files
  std::string_view name;
  size_t parameters;
};
const ColmapModel* findColmapModel(int id);
const ColmapModel* findColmapModel(std::string_view name);

// Converts a camera of COLMAP to a lens. Throws Error(BadInput) whose message begins with `where`.
scene::Lens lensOfColmap(const ColmapModel& model, double width, double height, std::span<const double> parameters,
                         const std::string& where);

struct ColmapCamera {
  const ColmapModel* model;
  std::vector<double> parameters;
};
ColmapCamera colmapCameraOf(const CalibratedCamera& camera);

// A world-to-camera pose as in COLMAP's files: a quaternion w x y z and a translation.
struct ColmapPose {
  glm::dvec4 rotation;
  glm::dvec3 translation;
};
ColmapPose colmapPoseOf(const glm::dmat4& pose);
glm::dmat4 poseOfColmap(const ColmapPose& pose, const std::string& where);

// The observations of a model by image. An observation's index in its image is its number in tracks.
struct ColmapFeature {
  glm::dvec2 pixel{0};
  uint64_t point = 0;  // index of the point
};
struct ColmapFeatures {
  std::vector<std::vector<ColmapFeature>> ofImage;
  std::vector<std::vector<uint32_t>> ofPoint;  // the number of each observation of a track in its image
};
ColmapFeatures featuresOf(size_t images, std::span<const ColmapPoint> points);

// The distinct lenses of cameras, and the lens of each camera.
struct ColmapLenses {
  std::vector<const CalibratedCamera*> cameras;  // one camera per lens
  std::vector<uint32_t> lensOf;                  // lens index by camera
};
ColmapLenses differentLenses(std::span<const CalibratedCamera> cameras);

}  // namespace latelight::data
