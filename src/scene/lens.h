// How a camera maps directions to pixels, where a field of view and a principal point do not say it.
#pragma once

#include <array>
#include <cstdint>

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
};

}  // namespace latelight::scene
