// A camera as files of cameras hold it.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data/cameras/source.h"
#include "scene/lens.h"

namespace latelight::data {

struct CalibratedCamera {
  std::string name;                 // its picture's, or a number or a time, as the file has it
  std::optional<scene::Lens> lens;  // none: the file doesn't say
  glm::dmat4 pose{1};               // OpenCV's camera frame to the file's world, metres
};

// The memory of the cameras that a reader has found so far. Files say less of a camera than it takes.
class CameraMemory {
 public:
  void add(const CalibratedCamera& camera);  // before it is put into a list

 private:
  uint64_t bytes_ = 0, claimed_ = 0;
  MemoryClaim claim_;
};

// What all sources of files share, beside the file's name: "scale" (metres of the file's unit), "axes" (of the file's
// world: "scene", "y-up" or "z-up"), "size", and the keys of a lens where the file has none. Gives the cameras their
// places in the scene.
std::vector<Shot> placeCameras(Spec& spec, const CameraContext& context, const std::vector<CalibratedCamera>& cameras);

// A rotation from w x y z, of any length but 0; and back, with w at least 0.
glm::dmat3 rotationOf(glm::dvec4 wxyz);
glm::dvec4 quaternionOf(const glm::dmat3& rotation);

// A rigid transform's inverse.
glm::dmat4 inverseOf(const glm::dmat4& pose);

// Throws Error(BadInput) that begins with `where` for what no picture has: sizes that are not from 1 to 65536, focal
// lengths that are not above 0, numbers that are not finite.
void checkLens(const scene::Lens& lens, const std::string& where);

// The name of a picture without folders' "./" and its ending, for a camera.
std::string stemOf(const std::string& picture);

}  // namespace latelight::data
