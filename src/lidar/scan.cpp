#include "lidar/scan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/error.h"
#include "base/parallel.h"

namespace latelight::lidar {

using glm::dmat3, glm::dmat4, glm::dvec3;

namespace {

constexpr size_t kRaysAtOnce = size_t{1} << 20;
constexpr size_t kFiringsOfTask = 512;

// One point that the sensor reports.
struct Return {
  uint32_t firing, ray;  // ray: index among the rays that are cast together
  Echo echo;
};

// The hits of the rays that are cast together.
struct Hits {
  std::vector<float> distance, intensity;
  std::vector<uint32_t> id, part, material;

  void resize(size_t count) {
    distance.resize(count), intensity.resize(count);
    id.resize(count), part.resize(count), material.resize(count);
  }
};

class Scanner {
 public:
  Scanner(render::Renderer& renderer, const Pattern& pattern, std::span<const dmat4> poses,
          const render::Settings& settings, const ScanOptions& options)
      : renderer_(renderer),
        pattern_(pattern),
        poses_(poses),
        settings_(settings),
        options_(options),
        offsets_(beamOffsets(pattern.properties, options.samples)) {}

  // Scans with firings during which the scene does not change.
  void scan(std::span<const uint32_t> firings, const render::SceneState& state, Points& points) {
    const size_t most = std::max<size_t>(1, kRaysAtOnce / options_.samples);
    for (size_t first = 0; first < firings.size(); first += most)
      scanChunk(firings.subspan(first, std::min(most, firings.size() - first)), state, points);
  }

 private:
  const dmat4& poseOf(uint32_t firing) const { return poses_.size() == 1 ? poses_.front() : poses_[firing]; }

  void scanChunk(std::span<const uint32_t> firings, const render::SceneState& state, Points& points) {
    aim(firings);
    // Noise may move a surface beyond the maximum range nearer.
    const double limit = pattern_.properties.maxRange + 10 * pattern_.properties.rangeNoise;
    hits_.resize(origins_.size());
    renderer_.cast({origins_, directions_, limit},
                   render::CastTargets{.distance = hits_.distance.data(),
                                       .id = hits_.id.data(),
                                       .part = hits_.part.data(),
                                       .material = hits_.material.data(),
                                       .intensity = hits_.intensity.data()},
                   settings_, state);
    std::vector<std::vector<Return>> found((firings.size() + kFiringsOfTask - 1) / kFiringsOfTask);
    parallelFor(found.size(), 1, [&](size_t begin, size_t end) {
      for (size_t task = begin; task < end; ++task) {
        const size_t first = task * kFiringsOfTask;
        for (size_t i = first; i < std::min(first + kFiringsOfTask, firings.size()); ++i)
          measure(firings[i], i, found[task]);
      }
    });
    for (const std::vector<Return>& some : found)
      for (const Return& each : some) add(each, points);
  }

  void aim(std::span<const uint32_t> firings) {
    const size_t samples = options_.samples;
    origins_.resize(firings.size() * samples);
    directions_.resize(firings.size() * samples);
    parallelFor(firings.size(), kFiringsOfTask, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const dmat4& pose = poseOf(firings[i]);
        const std::span<dvec3> rays = std::span(directions_).subspan(i * samples, samples);
        beamRays(pattern_.directions[firings[i]], offsets_, rays);
        for (dvec3& ray : rays) ray = dmat3(pose) * ray;
        std::ranges::fill(std::span(origins_).subspan(i * samples, samples), dvec3(pose[3]));
      }
    });
  }

  void measure(uint32_t firing, size_t beam, std::vector<Return>& found) const {
    const size_t samples = options_.samples, first = beam * samples;
    std::vector<Echo> echoes = echoesOf(pattern_.properties, std::span(hits_.distance).subspan(first, samples),
                                        std::span(hits_.intensity).subspan(first, samples));
    detect(pattern_.properties, options_.seed, firing, echoes);
    select(options_.returns, echoes);
    for (const Echo& echo : echoes) found.push_back({firing, static_cast<uint32_t>(first + echo.ray), echo});
  }

  void add(const Return& each, Points& points) const {
    const dvec3 position = pattern_.directions[each.firing] * each.echo.range;
    points.position.emplace_back(position);
    points.worldPosition.push_back(dvec3(poseOf(each.firing) * glm::dvec4(position, 1)) -
                                   settings_.positionOrigin.point);
    points.time.push_back(pattern_.times[each.firing]);
    points.range.push_back(static_cast<float>(each.echo.range));
    points.intensity.push_back(static_cast<float>(each.echo.intensity));
    points.ring.push_back(pattern_.rings[each.firing]);
    points.echo.push_back(each.echo.number);
    points.firing.push_back(each.firing);
    points.id.push_back(hits_.id[each.ray]);
    points.part.push_back(hits_.part[each.ray]);
    points.material.push_back(hits_.material[each.ray]);
  }

  render::Renderer& renderer_;
  const Pattern& pattern_;
  std::span<const dmat4> poses_;
  const render::Settings& settings_;
  const ScanOptions& options_;
  std::vector<glm::dvec2> offsets_;
  std::vector<dvec3> origins_, directions_;
  Hits hits_;
};

// Returns the firings by slice. The period has `slices` of them from 0 on, and firings outside it are in slices below 0
// and above. Indices are whole numbers, which only doubles can hold for all times.
std::map<double, std::vector<uint32_t>> firingsOfSlices(const Pattern& pattern, uint32_t slices) {
  std::map<double, std::vector<uint32_t>> firings;
  for (uint32_t i = 0; i < pattern.times.size(); ++i)
    firings[std::floor(pattern.times[i] / pattern.period * slices)].push_back(i);
  return firings;
}

// Puts the points of slices whose firings are not in the order of their times into the order of the firings.
void orderByFiring(Points& points) {
  if (std::ranges::is_sorted(points.firing)) return;
  std::vector<size_t> order(points.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, {}, [&](size_t i) { return points.firing[i]; });
  const auto reorder = [&](auto& values) {
    auto sorted = values;
    for (size_t i = 0; i < order.size(); ++i) sorted[i] = values[order[i]];
    values = std::move(sorted);
  };
  reorder(points.position), reorder(points.worldPosition), reorder(points.time), reorder(points.range);
  reorder(points.intensity), reorder(points.ring), reorder(points.echo), reorder(points.id);
  reorder(points.part), reorder(points.material), reorder(points.firing);
}

}  // namespace

std::vector<output::PointField> fieldsOf(const Points& points, bool world, std::vector<float>& buffer) {
  const size_t count = points.size();
  buffer.resize(3 * count);
  for (int axis = 0; axis < 3; ++axis)
    for (size_t i = 0; i < count; ++i)
      buffer[axis * count + i] = world ? static_cast<float>(points.worldPosition[i][axis]) : points.position[i][axis];
  const std::span<const float> all(buffer);
  return {{"x", all.subspan(0, count)},         {"y", all.subspan(count, count)},
          {"z", all.subspan(2 * count, count)}, {"intensity", std::span(points.intensity)},
          {"time", std::span(points.time)},     {"ring", std::span(points.ring)},
          {"range", std::span(points.range)},   {"echo", std::span(points.echo)},
          {"firing", std::span(points.firing)}, {"id", std::span(points.id)},
          {"part", std::span(points.part)},     {"material", std::span(points.material)}};
}

Points scan(render::Renderer& renderer, const Pattern& pattern, std::span<const dmat4> poses, const StateAt& stateAt,
            const render::Settings& settings, const ScanOptions& options) {
  check(pattern);
  if (options.samples < 1 || options.samples > kMaxRaysOfBeam)
    badUsage("samples must be a whole number from 1 to {}, not {}", kMaxRaysOfBeam, options.samples);
  if (options.slices < 1 || options.slices > kMaxSlices)
    badUsage("slices must be a whole number from 1 to {}, not {}", kMaxSlices, options.slices);
  if (poses.size() != 1 && poses.size() != pattern.times.size())
    badUsage("a scan of {} firings needs one pose, or one per firing, not {}", pattern.times.size(), poses.size());
  Scanner scanner(renderer, pattern, poses, settings, options);
  Points points;
  for (const auto& [slice, firings] : firingsOfSlices(pattern, options.slices))
    scanner.scan(firings, stateAt((slice + 0.5) * pattern.period / options.slices), points);
  orderByFiring(points);
  return points;
}

}  // namespace latelight::lidar
