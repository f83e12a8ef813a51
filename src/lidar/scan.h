// Scans of a scene by a lidar sensor.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "lidar/echoes.h"
#include "lidar/sensor.h"
#include "output/points.h"
#include "render/submit/renderer.h"

namespace latelight::lidar {

inline constexpr uint32_t kMaxRaysOfBeam = 1024, kMaxSlices = 100'000;

struct ScanOptions {
  uint32_t samples = 1;  // rays per beam; 1: beams have no width
  Returns returns = Returns::Strongest;
  std::optional<uint64_t> seed = 0;  // of the noise; null: none
  // Number of parts of the period, each of which shows the scene at the time of its middle. Firings before and after
  // the period belong to further parts of the same length.
  uint32_t slices = 1;
};

// One value per point, in the order of the firings, and from the nearest within a firing.
struct Points {
  std::vector<glm::vec3> position;  // meters, in the sensor's frame at the time of the firing
  // Meters, in the frame of Settings::axes and relative to Settings::positionOrigin.
  std::vector<glm::dvec3> worldPosition;
  std::vector<double> time;  // seconds since the scan began
  std::vector<float> range, intensity;
  std::vector<uint16_t> ring;
  std::vector<uint8_t> echo;     // 0: the nearest echo of the firing that was detected
  std::vector<uint32_t> firing;  // index in the pattern
  std::vector<uint32_t> id, part, material;

  size_t size() const { return time.size(); }
};

// The values of points as files contain them. The positions are those in the sensor's frame, or in the world. The
// fields refer to `points` and to `buffer`.
std::vector<output::PointField> fieldsOf(const Points& points, bool world, std::vector<float>& buffer);

// Returns the scene's state at a time in seconds since the scan began.
using StateAt = std::function<render::SceneState(double seconds)>;

// Scans the scene once. `poses` are worldFromSensor, rigid and in the frame of Settings::axes: one, or one per firing.
// Calls `stateAt` with the middle of each slice that has firings. Memory is bounded, whatever the number of rays.
// Throws Error(Usage) if an argument is not valid.
Points scan(render::Renderer& renderer, const Pattern& pattern, std::span<const glm::dmat4> poses,
            const StateAt& stateAt, const render::Settings& settings, const ScanOptions& options);

}  // namespace latelight::lidar
