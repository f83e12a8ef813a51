// Sparse points of images with a rolling shutter: depth maps of a plane from a closed form, and points on the plane.
#include "data/formats/sparse_points.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

namespace latelight::data {
namespace {

using glm::dmat4;
using glm::dvec2;
using glm::dvec3;

constexpr uint32_t kWidth = 80, kHeight = 60;
constexpr double kDistance = 4;             // of the plane from the world's origin
const dvec3 kNormal(0, 0.6, 0.8);           // of the plane
const double kFocal = 70, kFocalEdge = 74;  // in pixels; the camera zooms

// A camera that moves and turns while its rows are read out.
struct MovingCamera {
  dvec3 eye, velocity, axis;  // meters, meters per readout
  double angle;               // radians per readout, about the axis

  // `share`: of the readout, from -1/2 at the upper edge of the image to 1/2 at the lower one.
  dmat4 at(double share) const {
    return glm::rotate(glm::translate(dmat4(1), eye + share * velocity), share * angle, axis);
  }
  static double focalAt(double share) { return kFocal + (kFocalEdge - kFocal) * 2 * std::abs(share); }
  static double shareOf(double row) { return row / kHeight - 0.5; }

  PointView view() const {
    const auto viewAt = [this](double share) {
      const double focal = focalAt(share);
      return PointView{{scene::LensModel::Pinhole, kWidth, kHeight, focal, focal, kWidth / 2.0, kHeight / 2.0},
                       at(share)};
    };
    PointView view = viewAt(0);
    view.edges = {viewAt(-0.5), viewAt(0.5)};
    return view;
  }

  std::vector<float> depth() const {
    std::vector<float> depth;
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        const double share = shareOf(y + 0.5), focal = focalAt(share);
        const dvec3 direction =
            glm::dmat3(at(share)) * dvec3((x + 0.5 - kWidth / 2.0) / focal, (y + 0.5 - kHeight / 2.0) / focal, 1);
        depth.push_back(
            static_cast<float>((kDistance - glm::dot(kNormal, dvec3(at(share)[3]))) / glm::dot(kNormal, direction)));
      }
    return depth;
  }

  // Projects a point at the time of a row.
  dvec2 project(const dvec3& point, double row) const {
    const dvec3 c(glm::inverse(at(shareOf(row))) * glm::dvec4(point, 1));
    return dvec2(kWidth, kHeight) / 2.0 + focalAt(shareOf(row)) * dvec2(c) / c.z;
  }
};

TEST(SparsePoints, OfARollingShutterLieOnTheSurface) {
  const std::vector<MovingCamera> cameras{{{0, 0, 0}, {0.5, 0.3, -0.2}, glm::normalize(dvec3(1, 2, 0)), 0.2},
                                          {{0.4, -0.2, 0.3}, {-0.4, -0.3, 0.1}, glm::normalize(dvec3(0, -1, 1)), 0.15}};
  std::vector<PointView> views;
  for (const MovingCamera& camera : cameras) views.push_back(pointView(describe(camera.view())));
  const output::ReadImage gray{
      .width = kWidth, .height = kHeight, .channels = {{.name = "Y", .values = std::vector(kWidth * kHeight, 0.5)}}};
  const std::vector<ColmapPoint> points = findSparsePoints(
      views, 5, [&](size_t i) { return cameras[i].depth(); }, [&](size_t) { return gray; });
  ASSERT_GT(points.size(), 150u);
  size_t shared = 0;
  for (const ColmapPoint& point : points) {
    EXPECT_NEAR(glm::dot(kNormal, point.position), kDistance, 1e-5);
    ASSERT_GE(point.track.size(), 1u);
    shared += point.track.size() == 2;
    for (const ColmapObservation& seen : point.track) {
      // The row's time is that of its center. A point between two rows may be in both or in neither.
      const dvec2 pixel = cameras[seen.image].project(point.position, std::floor(seen.pixel.y) + 0.5);
      EXPECT_LE(glm::distance(pixel, seen.pixel), 0.5);
    }
  }
  EXPECT_GT(shared, 100u);
}

}  // namespace
}  // namespace latelight::data
