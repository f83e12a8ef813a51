// Cameras read from files: a name, an optional lens, and a pose.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data/cameras/exposure.h"
#include "data/cameras/source.h"
#include "scene/lens.h"

namespace latelight::data {

struct CalibratedCamera {
  std::string name;                 // the picture's name, or a number or time, as written in the file
  std::optional<scene::Lens> lens;  // empty if the file has no intrinsics
  glm::dmat4 pose{1};               // OpenCV's camera frame to the file's world, in meters
  CameraExposure exposure{};        // empty values if the file states none
};

// Claims the memory of the cameras that a reader has read so far. A camera in memory may be larger than its text.
class CameraMemory {
 public:
  void add(const CalibratedCamera& camera);  // call before the camera is added to a list

 private:
  uint64_t bytes_ = 0, claimed_ = 0;
  MemoryClaim claim_;
};

// Transforms cameras of a file to the scene. Reads the keys that all file sources share in addition to the file's name:
// "scale" (meters per unit of the file), "axes" (of the file's world: "scene", "y-up" or "z-up"), "size", and the keys
// of a lens if the file has no lenses.
std::vector<Shot> placeCameras(Spec& spec, const CameraContext& context, const std::vector<CalibratedCamera>& cameras);

// Convert a quaternion w x y z of any length except 0 to a rotation, and a rotation to a unit quaternion with w >= 0.
glm::dmat3 rotationOf(glm::dvec4 wxyz);
glm::dvec4 quaternionOf(const glm::dmat3& rotation);

// Returns the inverse of a rigid transform.
glm::dmat4 inverseOf(const glm::dmat4& pose);

// Validates a lens: sizes must be whole numbers from 1 to 65536, focal lengths above 0, and all numbers finite. Throws
// Error(BadInput) whose message begins with `where`.
void checkLens(const scene::Lens& lens, const std::string& where);

// Returns a camera's name from a picture's path: the path without leading "./" and "../" and without the extension.
std::string stemOf(const std::string& picture);

}  // namespace latelight::data
