// How a camera maps directions to pixels, where a field of view and a principal point do not say it.
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
  Fisheye,          // Kannala and Brandt's, as OpenCV's: k1 k2 k3 k4, of the angle to the axis
  Equirectangular,  // all around: the axis in the middle, longitude to the right, latitude up
  CubeMap,          // six faces side by side: +X -X +Y -Y +Z -Z, of the camera's frame (X right, Y down, Z forward)
};

// Calibrated for pictures of width x height pixels; one of another size is the same picture, scaled. Pixel centres are
// at half-integers: a centred principal point is (width / 2, height / 2).
struct Lens {
  LensModel model = LensModel::Pinhole;
  double width = 0, height = 0;
  // Pixels; equirectangular pictures and cube maps have none.
  double fx = 0, fy = 0, cx = 0, cy = 0;
  std::array<double, 8> distortion{};  // the first of them, as the model says
  bool operator==(const Lens&) const = default;
};

// A name on the command line and in files, and how many coefficients of distortion the model has.
struct LensModelInfo {
  LensModel model;
  const char* name;
  uint32_t coefficients;
  bool calibrated;  // has focal lengths and a principal point
};
const LensModelInfo& infoOf(LensModel model);
const LensModelInfo* findLensModel(std::string_view name);  // null: there is none

// "NAME" or "NAME:fx,fy,cx,cy[,coefficients]", calibrated for a picture of that size. Throws Error(Usage), `option`
// first, for what can't be.
Lens parseLens(std::string_view option, std::string_view text, uint32_t width, uint32_t height);
// Throws Error(Usage) for numbers that no lens has, and for pictures of that size that the model does not have.
void checkLens(const Lens& lens, uint32_t width, uint32_t height);

// The same lens, calibrated for pictures of another size.
Lens scaledTo(const Lens& lens, uint32_t width, uint32_t height);

// The projection of a lens in double precision, between directions of the camera's frame (X right, Y down, Z forward)
// and pixel coordinates of the pictures that it is calibrated for.
//
// A polynomial of distortion may turn back, and a pixel would see two directions. Only what lies on this side of the
// first turn, and of the first pole of a rational one, is seen: all other directions and pixels have none.
class LensProjection {
 public:
  explicit LensProjection(const Lens& lens);

  // Of a direction of any length but 0.
  std::optional<glm::dvec2> project(glm::dvec3 direction) const;
  // The unit direction that a pixel coordinate sees.
  std::optional<glm::dvec3> unproject(glm::dvec2 pixel) const;
  // Metres along the camera's axis for a metre along this unit direction: along the axis of its face in a cube map, and
  // 1 in an equirectangular picture, which has no axis.
  double depthOf(glm::dvec3 direction) const;

 private:
  Lens lens_;
  double most_ = 0;  // the first turn: of the distance from the axis squared, at 1 m, or of the angle
};

}  // namespace latelight::scene
