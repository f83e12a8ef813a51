#include "data/formats/sparse_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "base/memory.h"
#include "base/parallel.h"
#include "data/formats/geometry.h"
#include "render/exposure/camera_motion.h"

namespace latelight::data {

using Json = nlohmann::ordered_json;

namespace {

static_assert(std::endian::native == std::endian::little, "points are written as they lie in memory");

constexpr double kTolerance = 0.01;  // of a point's depth
constexpr size_t kGrain = 4096;      // points per task

// The lens and the pose of an image's row.
struct RowView {
  explicit RowView(const PointView& view)
      : projection(view.lens),
        worldFromCamera(view.worldFromCamera),
        cameraFromWorld(inverseOf(view.worldFromCamera)) {}

  scene::LensProjection projection;
  glm::dmat4 worldFromCamera, cameraFromWorld;
};

// Returns the view at a share of the way to another one, which CameraMotion covers at constant speed. The lens changes
// linearly.
PointView between(const PointView& from, const PointView& to, double share) {
  PointView view{from.lens};
  for (double scene::Lens::*each : {&scene::Lens::fx, &scene::Lens::fy, &scene::Lens::cx, &scene::Lens::cy})
    view.lens.*each += (to.lens.*each - from.lens.*each) * share;
  view.worldFromCamera = render::poseBetween(from.worldFromCamera, to.worldFromCamera, share);
  return view;
}

// Returns one view for all rows, or a view per row at the time of the row's center.
std::vector<RowView> rowsOf(const PointView& view) {
  std::vector<RowView> rows;
  if (view.edges.empty()) {
    rows.emplace_back(view);
    return rows;
  }
  const auto height = static_cast<uint32_t>(view.lens.height);
  for (uint32_t y = 0; y < height; ++y) {
    const double fromMiddle = 2 * (y + 0.5) / height - 1;  // -1 at the upper edge, 1 at the lower one
    rows.emplace_back(between(view, view.edges[fromMiddle < 0 ? 0 : 1], std::abs(fromMiddle)));
  }
  return rows;
}

// A view with its depth map.
class DepthView {
 public:
  DepthView(const PointView& view, std::vector<float> depth)
      : rows_(rowsOf(view)),
        width_(static_cast<uint32_t>(view.lens.width)),
        height_(static_cast<uint32_t>(view.lens.height)),
        depth_(std::move(depth)) {}

  uint32_t width() const { return width_; }
  uint32_t height() const { return height_; }

  // Returns the pixel coordinates of a point that the view shows.
  std::optional<glm::dvec2> find(const glm::dvec3& point) const {
    const std::optional<Projection> found = project(point);
    if (!found || !contains(found->pixel)) return std::nullopt;
    const glm::dvec2 pixel = found->pixel;
    const double depth = depthAt(static_cast<uint32_t>(pixel.x), static_cast<uint32_t>(pixel.y));
    if (!(std::abs(depth - found->depth) <= kTolerance * found->depth)) return std::nullopt;
    return pixel;
  }

  // Returns the point at the center of a pixel, or nullopt for background.
  std::optional<glm::dvec3> pointAt(uint32_t x, uint32_t y) const {
    const double depth = depthAt(x, y);
    if (!(depth > 0) || std::isinf(depth)) return std::nullopt;
    const auto& [projection, worldFromCamera, ignored] = rows_[rows_.size() == 1 ? 0 : y];
    const std::optional<glm::dvec3> direction = projection.unproject({x + 0.5, y + 0.5});
    if (!direction || !(projection.depthOf(*direction) > 0)) return std::nullopt;
    return glm::dvec3(worldFromCamera * glm::dvec4(*direction * (depth / projection.depthOf(*direction)), 1));
  }

 private:
  struct Projection {
    glm::dvec2 pixel;
    double depth;
  };

  bool contains(glm::dvec2 pixel) const {
    return pixel.x >= 0 && pixel.y >= 0 && pixel.x < width_ && pixel.y < height_;
  }
  double depthAt(uint32_t x, uint32_t y) const { return depth_[size_t{y} * width_ + x]; }

  std::optional<Projection> project(const glm::dvec3& point, const RowView& row) const {
    const glm::dvec3 inCamera(row.cameraFromWorld * glm::dvec4(point, 1));
    if (!(inCamera.z > 0)) return std::nullopt;
    const std::optional<glm::dvec2> pixel = row.projection.project(inCamera);
    if (!pixel) return std::nullopt;
    return Projection{*pixel, inCamera.z};
  }

  // Returns the projection by the row that the point projects to, or by a neighbor of this row. Nothing if no row shows
  // the point, or if the iteration of rows does not converge.
  std::optional<Projection> project(const glm::dvec3& point) const {
    constexpr int kMaxSteps = 32;
    size_t row = rows_.size() / 2;
    for (int step = 0; step < kMaxSteps; ++step) {
      const std::optional<Projection> found = project(point, rows_[row]);
      if (!found || rows_.size() == 1) return found;
      const double last = static_cast<double>(rows_.size() - 1);
      const auto next = static_cast<size_t>(std::clamp(std::floor(found->pixel.y), 0.0, last));
      const bool isNeighbor = next + 1 == row || next == row + 1;
      if (next == row || (isNeighbor && step > kMaxSteps / 2)) return found;
      row = next;
    }
    return std::nullopt;
  }

  std::vector<RowView> rows_;  // one for all rows, or one per row
  uint32_t width_, height_;
  std::vector<float> depth_;
};

// Calls visit(i, pixel) for each point that the view shows, concurrently.
template <typename Visit>
void forVisible(const DepthView& view, const std::vector<ColmapPoint>& points, const Visit& visit) {
  parallelFor(points.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      if (const std::optional<glm::dvec2> pixel = view.find(points[i].position)) visit(i, *pixel);
  });
}

struct PixelPosition {
  uint32_t x = 0, y = 0;
};

// Returns the centers of the squares in which the view shows none of the points.
std::vector<PixelPosition> freeSquares(const DepthView& view, uint32_t spacing,
                                       const std::vector<ColmapPoint>& points) {
  const uint32_t columns = (view.width() + spacing - 1) / spacing, rows = (view.height() + spacing - 1) / spacing;
  std::vector<std::atomic<bool>> occupied(size_t{columns} * rows);
  forVisible(view, points, [&](size_t, const glm::dvec2& pixel) {
    const auto column = static_cast<uint32_t>(pixel.x) / spacing, row = static_cast<uint32_t>(pixel.y) / spacing;
    occupied[size_t{row} * columns + column].store(true, std::memory_order_relaxed);
  });
  std::vector<PixelPosition> centers;
  for (uint32_t row = 0; row < rows; ++row)
    for (uint32_t column = 0; column < columns; ++column)
      if (!occupied[size_t{row} * columns + column])
        centers.push_back({std::min(column * spacing + spacing / 2, view.width() - 1),
                           std::min(row * spacing + spacing / 2, view.height() - 1)});
  return centers;
}

std::array<uint8_t, 3> colorAt(const output::ReadImage& image, PixelPosition pixel) {
  std::array<uint8_t, 3> color;
  for (size_t i = 0; i < 3; ++i) {
    const output::Channel& channel = image.channels.at(std::min(i, image.channels.size() - 1));
    color[i] = static_cast<uint8_t>(std::lround(255 * channel.values.at(size_t{pixel.y} * image.width + pixel.x)));
  }
  return color;
}

}  // namespace

PointView pointViewOf(const DataFrame& frame) {
  const double width = frame.picture.width, height = frame.picture.height;
  const auto viewOf = [&](const output::CameraMetadata& camera) {
    const std::array<double, 9>& k = camera.intrinsics;
    const scene::Lens pinhole{scene::LensModel::Pinhole, width, height, k[0], k[4], k[2], k[5]};
    return PointView{camera.lens.value_or(pinhole), inverseOf(openCvFromWorld(camera))};
  };
  PointView view = viewOf(frame.metadata.camera);
  for (const output::CameraMetadata& edge : frame.edges) view.edges.push_back(viewOf(edge));
  return view;
}

Json describe(const PointView& view) {
  const scene::Lens& lens = view.lens;
  Json json{{"model", infoOf(lens.model).name},
            {"lens", {lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy}},
            {"distortion", lens.distortion},
            {"pose", output::rowsOf(view.worldFromCamera)}};
  for (const PointView& edge : view.edges) json["edges"].push_back(describe(edge));
  return json;
}

PointView pointView(const Json& json) {
  const Json &lens = json["lens"], &pose = json["pose"];
  PointView view{{scene::findLensModel(json["model"].get<std::string>())->model, lens[0], lens[1], lens[2], lens[3],
                  lens[4], lens[5], json["distortion"].get<std::array<double, 8>>()}};
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      view.worldFromCamera[column][row] = pose[static_cast<size_t>(row)][static_cast<size_t>(column)];
  if (const auto edges = json.find("edges"); edges != json.end())
    for (const Json& edge : *edges) view.edges.push_back(pointView(edge));
  return view;
}

std::vector<ColmapPoint> findSparsePoints(const std::vector<PointView>& views, uint32_t spacing,
                                          const LoadDepth& loadDepth, const LoadImage& loadImage) {
  std::vector<ColmapPoint> points;
  MemoryClaim memory;
  for (size_t i = 0; i < views.size(); ++i) {
    const DepthView view(views[i], loadDepth(i));
    std::optional<output::ReadImage> image;
    const size_t before = points.size();
    for (const PixelPosition pixel : freeSquares(view, spacing, points)) {
      const std::optional<glm::dvec3> position = view.pointAt(pixel.x, pixel.y);
      if (!position) continue;
      if (!image) image = loadImage(i);
      points.push_back({*position, colorAt(*image, pixel), {}});
    }
    memory.grow((points.size() - before) * sizeof(ColmapPoint), "sparse points");
  }
  for (size_t i = 0; i < views.size(); ++i) {
    std::atomic<uint64_t> found = 0;
    forVisible(DepthView(views[i], loadDepth(i)), points, [&](size_t point, const glm::dvec2& pixel) {
      points[point].track.push_back({static_cast<uint32_t>(i), pixel});
      found.fetch_add(1, std::memory_order_relaxed);
    });
    memory.grow(found * sizeof(ColmapObservation), "sparse points");
  }
  return points;
}

std::vector<std::byte> encodePly(const std::vector<ColmapPoint>& points) {
  std::string file = fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", points.size());
  for (const char* name : {"x", "y", "z"}) file += fmt::format("property float {}\n", name);
  for (const char* name : {"red", "green", "blue"}) file += fmt::format("property uchar {}\n", name);
  file += "end_header\n";
  for (const ColmapPoint& point : points) {
    const glm::vec3 position(point.position);
    file.append(reinterpret_cast<const char*>(&position), sizeof position);
    file.append(reinterpret_cast<const char*>(point.color.data()), point.color.size());
  }
  const auto bytes = std::as_bytes(std::span(file));
  return {bytes.begin(), bytes.end()};
}

}  // namespace latelight::data
