#include "render/lens/lens_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <optional>
#include <span>

#include "base/error.h"
#include "base/parallel.h"
#include "render/lens/lens_calibration.h"
#include "scene/scene.h"
#include "vk/device.h"

namespace latelight::render {

namespace {

using Rays = std::vector<shared::LensRay>;

// If all rays stay within 60 degrees of the axis, one pinhole view covers them. Beyond that, a single view would waste
// pixels at its edge.
constexpr float kOneView = 0.5f;
constexpr float kRim = 1;  // margin around all rays in pixels, for rounding
constexpr float kMaxPixels = 16384;

bool sees(const shared::LensRay& ray) {
  return ray.direction != glm::vec3(0);
}

// Returns the direction from a point of the aperture to where the ray through the lens's center is in focus.
glm::dvec3 focused(const LensPicture& p, glm::dvec3 ray) {
  if (p.aperture == glm::dvec2(0)) return ray;
  const double distance = p.lens.model == scene::LensModel::OpenCv ? p.focus / ray.z : p.focus;
  return glm::normalize(ray * distance - glm::dvec3(p.aperture.x, -p.aperture.y, 0));
}

// Returns the rays of the rows, of the row above and of the row below.
Rays raysOf(const LensPicture& p) {
  const scene::LensProjection projection(scene::scaledTo(p.lens, p.width, p.height));
  Rays rays(size_t{p.width} * (p.rows + 2));
  parallelFor(p.rows + 2, 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const double row = double(p.first + y) - 1;
      if (row < 0 || row >= p.height) continue;
      for (size_t x = 0; x < p.width; ++x) {
        const glm::dvec2 pixel(double(x) + 0.5 + p.jitter.x, row + 0.5 + p.jitter.y);
        const std::optional<glm::dvec3> central = projection.unproject(pixel);
        if (!central) continue;
        const glm::dvec3 ray = focused(p, *central);
        const glm::vec3 inView(glm::dvec3(ray.x, ray.z, -ray.y));
        rays[y * p.width + x] = {inView, static_cast<float>(projection.depthOf(ray))};
      }
    }
  });
  return rays;
}

constexpr uint32_t kAxes = 6;
// Right, forward and up axes of the pinhole view along each axis of the camera: +Y, -Y, +X, -X, +Z, -Z.
constexpr glm::vec3 kAlong[kAxes][3] = {
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},  {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}, {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
    {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}},  {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
};

// Returns the index in kAlong of the axis nearest to a direction.
uint32_t axisOf(glm::vec3 d) {
  const glm::vec3 a = glm::abs(d);
  if (a.y >= a.x && a.y >= a.z) return d.y >= 0 ? 0 : 1;
  if (a.x >= a.z) return d.x >= 0 ? 2 : 3;
  return d.z >= 0 ? 4 : 5;
}

// The extent on the plane at 1 m that the pinhole view along an axis must cover.
struct Extent {
  glm::vec2 low{std::numeric_limits<float>::infinity()}, high{-std::numeric_limits<float>::infinity()};
  float step = std::numeric_limits<float>::infinity();  // the size of the smallest pixel

  bool empty() const { return low.x > high.x; }
  void add(const Extent& other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
    step = std::min(step, other.step);
  }
};
using Extents = std::array<Extent, kAxes>;

struct RayGrid {
  const Rays& rays;
  size_t width;
  bool oneView;

  size_t height() const { return rays.size() / width - 2; }
  const shared::LensRay& at(size_t x, size_t y) const { return rays[(y + 1) * width + x]; }
  uint32_t axisAt(size_t x, size_t y) const { return oneView ? 0 : axisOf(at(x, y).direction); }
  glm::vec2 placeAt(size_t x, size_t y) const {
    const auto& [right, away, up] = kAlong[axisAt(x, y)];
    const glm::vec3 d = at(x, y).direction;
    return glm::vec2(glm::dot(d, right), glm::dot(d, up)) / glm::dot(d, away);
  }
  // Returns the distance to the next pixel, or else to the previous one; 0 if neither has a ray in the same pinhole
  // view.
  float stepAlong(size_t x, size_t y, size_t right, size_t down) const {
    for (const size_t sign : {size_t{1}, ~size_t{0}}) {
      const size_t otherX = x + sign * right, otherY = y + sign * down;
      if (otherX >= width || otherY >= height() || !sees(at(otherX, otherY))) continue;
      if (axisAt(x, y) == axisAt(otherX, otherY)) return glm::distance(placeAt(x, y), placeAt(otherX, otherY));
    }
    return 0;
  }
  // Returns the longer side of a pixel, because the other side is meaningless at the poles of an equirectangular
  // picture.
  float sizeOf(size_t x, size_t y) const {
    const float across = stepAlong(x, y, 1, 0), down = stepAlong(x, y, 0, 1);
    return across > 0 && down > 0 ? std::max(across, down) : std::numeric_limits<float>::infinity();
  }
  void addRow(Extents& extents, size_t y) const {
    for (size_t x = 0; x < width; ++x) {
      if (!sees(at(x, y))) continue;
      const glm::vec2 place = placeAt(x, y);
      extents[axisAt(x, y)].add({place, place, sizeOf(x, y)});
    }
  }
};

Extents extentsOf(const RayGrid& grid) {
  Extents all;
  std::mutex mutex;
  parallelFor(grid.height(), 8, [&](size_t begin, size_t end) {
    Extents some;
    for (size_t y = begin; y < end; ++y) grid.addRow(some, y);
    const std::lock_guard lock(mutex);
    for (size_t i = 0; i < all.size(); ++i) all[i].add(some[i]);
  });
  return all;
}

// `pixel`: the side of a pixel on the plane at 1 m.
shared::View pinholeView(uint32_t axis, const Extent& extent, glm::vec2 size, float pixel) {
  shared::View view{};
  const auto& [right, away, up] = kAlong[axis];
  view.viewToWorld = glm::mat4x3(right, away, up, glm::vec3(0));
  view.worldToView = glm::mat4x3(glm::transpose(glm::mat3(right, away, up)));
  view.size = size;
  const glm::vec2 scale = 2.0f / (size * pixel), offset = -scale * 0.5f * (extent.low + extent.high);
  view.projection = {scale.x, scale.y, 0, scene::kNearClip, offset.x, offset.y, shared::kPerspective};
  return view;
}

// The indices of the rays, sorted by the pixel of the pinhole views that contains them (counting sort).
struct Bins {
  std::vector<uint32_t> starts, pixels;
  uint32_t most = 0;  // maximum number of rays in one pixel
};

// lavapipe silently ends a shader's loops after 65535 iterations in total. The shader iterates over the rays in one
// pixel for each large triangle there, so this limits the number of rays in a pixel.
constexpr uint32_t kMaxOnCpu = 2048;

Bins binsOf(const RayGrid& grid, std::span<const shared::View> views, std::span<const uint32_t> viewOfAxis) {
  const auto width = static_cast<uint32_t>(views.front().size.x), height = static_cast<uint32_t>(views.front().size.y);
  constexpr uint32_t kNone = ~0u;
  std::vector<uint32_t> places(grid.width * grid.height(), kNone);
  parallelFor(grid.height(), 8, [&](size_t begin, size_t end) {
    for (size_t i = begin * grid.width; i < end * grid.width; ++i) {
      const size_t x = i % grid.width, y = i / grid.width;
      if (!sees(grid.at(x, y))) continue;
      const uint32_t number = viewOfAxis[grid.axisAt(x, y)];
      const shared::Projection& p = views[number].projection;
      const glm::vec2 ndc = glm::vec2(p.H, p.V) * grid.placeAt(x, y) + glm::vec2(p.X, p.Z);
      const glm::uvec2 at((0.5f + 0.5f * ndc.x) * views[number].size.x, (0.5f - 0.5f * ndc.y) * views[number].size.y);
      places[i] = (number * height + std::min(at.y, height - 1)) * width + std::min(at.x, width - 1);
    }
  });
  Bins bins;
  bins.starts.resize(size_t{width} * height * views.size() + 1);
  for (const uint32_t place : places)
    if (place != kNone) ++bins.starts[place + 1];
  bins.most = *std::ranges::max_element(bins.starts);
  std::partial_sum(bins.starts.begin(), bins.starts.end(), bins.starts.begin());
  bins.pixels.resize(std::max<size_t>(bins.starts.back(), 1));
  std::vector<uint32_t> next = bins.starts;
  for (size_t i = 0; i < places.size(); ++i)
    if (places[i] != kNone) bins.pixels[next[places[i]]++] = static_cast<uint32_t>(i);
  return bins;
}

}  // namespace

LensRays::LensRays(vk::Device& device, const LensPicture& picture)
    : lenses{calibrationOf(picture.lens, picture.width, picture.height),
             calibrationOf(picture.neighbors[0], picture.width, picture.height),
             calibrationOf(picture.neighbors[1], picture.width, picture.height)},
      aperture(picture.aperture),
      focus(static_cast<float>(picture.focus)) {
  const Rays table = raysOf(picture);
  rays = vk::uploadedBuffer(device, "lens rays", std::as_bytes(std::span(table)));
  const bool oneView =
      std::ranges::all_of(table, [](const shared::LensRay& ray) { return !sees(ray) || ray.direction.y >= kOneView; });
  const RayGrid grid{table, picture.width, oneView};
  Extents extents = extentsOf(grid);
  if (std::ranges::all_of(extents, &Extent::empty)) extents[0] = {glm::vec2(0), glm::vec2(0)};  // no pixel has a ray
  glm::vec2 largest(0);
  float step = std::numeric_limits<float>::infinity();
  for (const Extent& extent : extents) {
    if (extent.empty()) continue;
    largest = glm::max(largest, extent.high - extent.low);
    step = std::min(step, extent.step);
  }
  // The pixels of a picture that is one pixel wide or high have no measurable size.
  const float widest = std::max(largest.x, largest.y);
  if (!std::isfinite(step)) step = std::max(widest, 1e-3f) / static_cast<float>(std::max(picture.width, picture.rows));
  const float pixel = std::max(step, widest / (kMaxPixels - 2 * kRim - 2));
  // The size is even, so that four pixels share the rays around the pole of an equirectangular picture.
  const glm::vec2 size = 2.0f * glm::ceil(0.5f * largest / pixel) + 2 * kRim;
  std::array<uint32_t, kAxes> viewOfAxis{};
  for (uint32_t axis = 0; axis < kAxes; ++axis) {
    if (extents[axis].empty()) continue;
    viewOfAxis[axis] = static_cast<uint32_t>(views.size());
    views.push_back(pinholeView(axis, extents[axis], size, pixel));
  }
  const Bins bins = binsOf(grid, views, viewOfAxis);
  if (device.isCpu() && bins.most > kMaxOnCpu)
    badUsage(
        "on a CPU device at most {} pixels of an image may have nearly the same direction, such as those at a pole: "
        "use a smaller image",
        kMaxOnCpu);
  starts = vk::uploadedBuffer(device, "lens rays by pixels", std::as_bytes(std::span(bins.starts)));
  pixels = vk::uploadedBuffer(device, "lens pixels", std::as_bytes(std::span(bins.pixels)));
}

std::shared_ptr<const LensRays> LensRayCache::of(vk::Device& device, const LensPicture& picture) {
  constexpr size_t kMax = 16;
  const auto known = std::ranges::find(latest_, picture, &Entry::picture);
  if (known != latest_.end()) {
    latest_.splice(latest_.begin(), latest_, known);
  } else {
    latest_.push_front({picture, std::make_shared<const LensRays>(device, picture)});
    if (latest_.size() > kMax) latest_.pop_back();
  }
  return latest_.front().rays;
}

}  // namespace latelight::render
