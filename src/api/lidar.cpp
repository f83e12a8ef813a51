// The lidar sensors of the public API.
#include "lidar/scan.h"

#include <latelight/latelight.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

#include "api/renderer.h"
#include "api/settings.h"
#include "api/transform.h"
#include "base/error.h"
#include "base/files.h"
#include "base/lowercase.h"
#include "base/memory.h"
#include "output/points.h"

namespace latelight {

namespace {

lidar::Pattern internalPattern(const LidarPattern& from) {
  lidar::Pattern pattern{.name = from.name,
                         .times = from.times,
                         .rings = from.rings,
                         .period = from.period,
                         .properties = {from.minRange, from.maxRange, from.ratedRange, from.rangeNoise,
                                        from.rangeResolution, from.divergence, from.echoSeparation}};
  for (const std::array<double, 3>& d : from.directions) pattern.directions.emplace_back(d[0], d[1], d[2]);
  return pattern;
}

LidarPattern publicPattern(lidar::Pattern&& from) {
  LidarPattern pattern{.name = std::move(from.name),
                       .times = std::move(from.times),
                       .rings = std::move(from.rings),
                       .period = from.period,
                       .minRange = from.properties.minRange,
                       .maxRange = from.properties.maxRange,
                       .ratedRange = from.properties.ratedRange,
                       .rangeNoise = from.properties.rangeNoise,
                       .rangeResolution = from.properties.rangeResolution,
                       .divergence = from.properties.divergence,
                       .echoSeparation = from.properties.echoSeparation};
  for (const glm::dvec3& d : from.directions) pattern.directions.push_back({d.x, d.y, d.z});
  return pattern;
}

// Vectors of the API have the layout of glm's.
template <typename To, typename From>
std::vector<To> vectorsOf(const std::vector<From>& from) {
  static_assert(sizeof(To) == sizeof(From));
  std::vector<To> to(from.size());
  if (!from.empty()) std::memcpy(to.data(), from.data(), sizeof(To) * from.size());
  return to;
}

// Throws Error(Usage) if a pose is not rigid.
std::vector<glm::dmat4> internalPoses(std::span<const Transform> from) {
  constexpr double kTolerance = 1e-4;
  std::vector<glm::dmat4> poses;
  for (const Transform& rows : from) {
    const bool finite = std::ranges::all_of(rows, [](double number) { return std::isfinite(number); });
    if (!finite || !isRigid(poses.emplace_back(matrixOf(rows)), kTolerance))
      badUsage("poses of a sensor must be rigid: a rotation and a translation, without scale or reflection");
  }
  return poses;
}

}  // namespace

std::vector<LidarInfo> lidarInfos() {
  std::vector<LidarInfo> infos;
  for (const lidar::SensorInfo& info : lidar::sensors())
    infos.push_back({std::string(info.name), std::string(info.description)});
  return infos;
}

LidarPattern lidarPattern(const std::string& name, double rate, uint32_t columns, double start) {
  lidar::Sensor sensor = lidar::sensorNamed(name);
  if (rate != 0) sensor.rate = rate;
  auto* const spinning = std::get_if<lidar::Spinning>(&sensor.scanner);
  if (columns != 0 && (!spinning || spinning->cycle > 0))
    badUsage("the sensor {} has no fixed number of columns: omit columns", name);
  if (columns != 0) spinning->columns = columns;
  return publicPattern(lidar::patternOf(sensor, start));
}

LidarPattern lidarPattern(const SpinningLidar& s) {
  return publicPattern(
      lidar::patternOf({s.name, s.rate, lidar::Spinning{s.elevations, s.azimuths, s.firing, s.cycle, s.columns}}));
}

LidarPoints Renderer::scan(const LidarPattern& pattern, std::span<const Transform> poses, const LidarOptions& lidar,
                           const Options& options) try {
  const Impl::RayInput input = filled().rayInput(options);
  checkPlayback(input.settings);
  const auto stateAt = [&](double seconds) {
    if (lidar.slices == 1 || !options.time) return input.moment;
    Options later = options;
    later.time = *options.time + seconds;
    return filled().rayInput(later).moment;
  };
  lidar::Points points =
      lidar::scan(impl_->renderer, internalPattern(pattern), internalPoses(poses), stateAt, input.settings,
                  {lidar.samples, lidar::returnsNamed(lidar.returns), lidar.seed, lidar.slices});
  return {.position = vectorsOf<std::array<float, 3>>(points.position),
          .worldPosition = vectorsOf<std::array<double, 3>>(points.worldPosition),
          .time = std::move(points.time),
          .range = std::move(points.range),
          .intensity = std::move(points.intensity),
          .ring = std::move(points.ring),
          .echo = std::move(points.echo),
          .firing = std::move(points.firing),
          .id = std::move(points.id),
          .part = std::move(points.part),
          .material = std::move(points.material)};
} catch (const std::bad_alloc&) {
  failWithoutMemory("the points of the sensor");
}

namespace {

// Throws Error(Usage) unless all fields have one value per point.
void checkSizes(const LidarPoints& points) {
  const size_t count = points.time.size();
  const auto check = [count](const char* name, size_t values) {
    if (values != count)
      badUsage("all fields of points must have as many values, but {} has {} and time has {}", name, values, count);
  };
  check("position", points.position.size());
  check("worldPosition", points.worldPosition.size());
  check("range", points.range.size());
  check("intensity", points.intensity.size());
  check("ring", points.ring.size());
  check("echo", points.echo.size());
  check("firing", points.firing.size());
  check("id", points.id.size());
  check("part", points.part.size());
  check("material", points.material.size());
}

}  // namespace

void writePoints(const std::filesystem::path& path, const LidarPoints& from, bool world) try {
  checkSizes(from);
  const lidar::Points points{vectorsOf<glm::vec3>(from.position),
                             vectorsOf<glm::dvec3>(from.worldPosition),
                             from.time,
                             from.range,
                             from.intensity,
                             from.ring,
                             from.echo,
                             from.firing,
                             from.id,
                             from.part,
                             from.material};
  std::string format = lowercaseExtension(path);
  if (!format.empty()) format.erase(0, 1);
  std::vector<float> buffer;
  writeFile(path, output::encodePoints(format, lidar::fieldsOf(points, world, buffer)));
} catch (const std::bad_alloc&) {
  failWithoutMemory("the points of the sensor");
}

}  // namespace latelight
