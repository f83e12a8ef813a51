// Lens models: mappings from a camera's directions to pixels that a field of view and a principal point can't express.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace latelight::scene {

enum class LensModel : uint8_t {
  Pinhole,          // any focal lengths and principal point, without distortion
  OpenCv,           // with OpenCV's radial and tangential distortion: k1 k2 p1 p2 k3 k4 k5 k6
  Fisheye,          // Kannala and Brandt's model as in OpenCV, of the angle to the axis: k1 k2 k3 k4
  Equirectangular,  // all directions: axis at the center, longitude to the right, latitude up
  CubeMap,          // six faces side by side: +X -X +Y -Y +Z -Z, of the camera's frame (X right, Y down, Z forward)
  FTheta,           // the angle to the axis as a polynomial of the distance from the principal point: k0 to k5
};

// A lens calibrated for images of width x height pixels; an image of another size is the same image, scaled. Pixel
// centers are at half-integers: a centered principal point is (width / 2, height / 2).
struct Lens {
  LensModel model = LensModel::Pinhole;
  double width = 0, height = 0;
  // In pixels; unused by equirectangular images and cube maps.
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<double, 8> distortion{};  // the model's coefficients, then zeros
  bool operator==(const Lens&) const = default;
};

// A model's name on the command line and in files, and its number of distortion coefficients.
struct LensModelInfo {
  LensModel model;
  const char* name;
  uint32_t coefficients;
  bool calibrated;  // has focal lengths and a principal point
};
const LensModelInfo& infoOf(LensModel model);
const LensModelInfo* findLensModel(std::string_view name);  // null if there is none

// Parses "NAME" or "NAME:fx,fy,cx,cy[,coefficients]", calibrated for an image of that size. Throws Error(Usage), with
// `option` first in the message, for invalid text.
Lens parseLens(std::string_view option, std::string_view text, uint32_t width, uint32_t height);
// Throws Error(Usage) for invalid values, and for an image size that the model does not support.
void checkLens(const Lens& lens, uint32_t width, uint32_t height);

// Returns the same lens, calibrated for images of another size.
Lens scaledTo(const Lens& lens, uint32_t width, uint32_t height);

// The projection of a lens in double precision, between directions of the camera's frame (X right, Y down, Z forward)
// and pixel coordinates of the images for which it is calibrated.
//
// A distortion polynomial may turn back, so that a pixel would correspond to two directions. Only directions before the
// first turning point, and before the first pole of a rational polynomial, are visible. All other directions and pixels
// return nullopt.
class LensProjection {
 public:
  explicit LensProjection(const Lens& lens);

  // Projects a direction of any length except 0.
  std::optional<glm::dvec2> project(glm::dvec3 direction) const;
  // Returns the unit direction that a pixel coordinate corresponds to.
  std::optional<glm::dvec3> unproject(glm::dvec2 pixel) const;
  // Returns the depth in meters along the camera's axis per meter along this unit direction. Depth is along the face's
  // axis in a cube map, and the factor is 1 in an equirectangular image, which has no axis.
  double depthOf(glm::dvec3 direction) const;

 private:
  Lens lens_;
  // First turning point: of the squared distance from the axis at 1 m, of the angle, or (f-theta) of the distance from
  // the principal point.
  double most_ = 0;
};

}  // namespace latelight::scene
