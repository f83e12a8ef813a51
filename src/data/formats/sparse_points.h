// Sparse point clouds from the depth of several images of one scene at rest, as structure from motion returns them, but
// exact: points with the pixels of all images that show them.
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "data/cameras/colmap.h"
#include "data/frame.h"
#include "output/read.h"

namespace latelight::data {

// An image of the scene: its lens, calibrated for the image's size, and its pose.
struct PointView {
  scene::Lens lens;
  glm::dmat4 worldFromCamera{1};  // from OpenCV's camera frame
  // With a rolling shutter of a moving camera: two views, at the times of the image's upper and lower edge. This one is
  // then that of the image's time. Empty: all rows have the same time.
  std::vector<PointView> edges{};
};
PointView pointViewOf(const DataFrame& frame);
nlohmann::ordered_json describe(const PointView& view);
PointView pointView(const nlohmann::ordered_json& json);

// Load the planar depth of a view in meters, one value per pixel, where 0 and infinity are background, and its image.
using LoadDepth = std::function<std::vector<float>(size_t view)>;
using LoadImage = std::function<output::ReadImage(size_t view)>;

// Divides each view into squares of `spacing` pixels. Every square whose center shows a surface has a point: one that
// an earlier view already found in the square, or a new one at the square's center. Then finds all views that show each
// point: those in which the depth of the nearest pixel differs from the point's by at most 1 %. Each row of a rolling
// shutter has a pose of its own. Loads each depth map twice and each image at most once, one at a time. The result is
// the same for any number of threads.
std::vector<ColmapPoint> findSparsePoints(const std::vector<PointView>& views, uint32_t spacing,
                                          const LoadDepth& loadDepth, const LoadImage& loadImage);

// Encodes positions and colors as binary PLY.
std::vector<std::byte> encodePly(const std::vector<ColmapPoint>& points);

}  // namespace latelight::data
