#include "lidar/echoes.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/philox.h"
#include "scene/exact_math.h"

namespace latelight::lidar {

using glm::dvec2, glm::dvec3;

namespace {

constexpr double kLn2 = 0.69314718055994530942;

// Signals are relative to that of a surface of this reflectance at the rated range, which is detected with a
// probability of 90 %, as makers state ranges. The threshold is 4.5 standard deviations of the receiver's noise, which
// a Gaussian exceeds with a probability of 3.4e-6.
constexpr double kRatedReflectance = 0.8;
constexpr double kThresholdToNoise = 4.5;
constexpr double kQuantileOf90Percent = 1.2815515655446004;
constexpr double kSignalNoise = 1 / (kThresholdToNoise + kQuantileOf90Percent);
constexpr double kSignalThreshold = kThresholdToNoise * kSignalNoise;

double logarithm(double x) {
  return exact::logarithm2(x) * kLn2;
}

// Returns two independent normal values of an echo (Box and Muller 1958, "A Note on the Generation of Random Normal
// Deviates").
dvec2 normals(uint64_t seed, uint32_t firing, uint32_t echo) {
  constexpr uint32_t kStream = 0x6c696461;  // keeps these numbers apart from others with the same seed
  const PhiloxBlock bits =
      philox({firing, echo, kStream, 0}, {static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32)});
  const auto unit = [](uint32_t high, uint32_t low) {
    return static_cast<double>(uint64_t{high >> 5} << 26 | low >> 6) * 0x1p-53;
  };
  const double radius = std::sqrt(-2 * logarithm(1 - unit(bits[0], bits[1])));
  return radius * exact::onCircle(unit(bits[2], bits[3]));
}

}  // namespace

Returns returnsNamed(std::string_view name) {
  constexpr std::string_view kNames[] = {"strongest", "first", "last", "dual", "all"};
  const auto found = std::ranges::find(kNames, name);
  if (found == std::end(kNames)) badUsage("returns must be one of {}, not \"{}\"", fmt::join(kNames, ", "), name);
  return static_cast<Returns>(found - kNames);
}

std::vector<dvec2> beamOffsets(const Properties& properties, uint32_t rays) {
  std::vector<dvec2> offsets(rays);
  if (rays == 1) return offsets;
  const dvec2 radii = dvec2(properties.divergence[0], properties.divergence[1]) / 2.0;  // at 1/e^2
  const double goldenTurn = (3 - std::sqrt(5.0)) / 2;
  for (uint32_t i = 0; i < rays; ++i) {
    const double radius = std::sqrt(-0.5 * logarithm(1 - (i + 0.5) / rays));
    offsets[i] = radius * exact::onCircle(i * goldenTurn) * radii;
  }
  return offsets;
}

void beamRays(const dvec3& direction, std::span<const dvec2> offsets, std::span<dvec3> rays) {
  const dvec3 across(direction.y, -direction.x, 0);
  const double length = glm::length(across);
  const dvec3 right = length > 1e-9 ? across / length : dvec3(0, -1, 0), up = glm::cross(right, direction);
  for (size_t i = 0; i < offsets.size(); ++i)
    rays[i] = glm::normalize(direction + offsets[i].x * right + offsets[i].y * up);
}

std::vector<Echo> echoesOf(const Properties& properties, std::span<const float> distances,
                           std::span<const float> intensities) {
  std::vector<uint32_t> order;
  for (uint32_t ray = 0; ray < distances.size(); ++ray)
    if (std::isfinite(distances[ray])) order.push_back(ray);
  std::ranges::stable_sort(order, {}, [&](uint32_t ray) { return distances[ray]; });
  std::vector<Echo> echoes;
  double last = -std::numeric_limits<double>::infinity(), most = 0;
  for (const uint32_t ray : order) {
    const double distance = distances[ray], share = double{intensities[ray]} / double(distances.size());
    // A Lambertian surface that fills the beam returns its intensity over the square of the distance.
    const double power = share / std::pow(std::max(distance, 1e-3), 2);
    if (distance - last > properties.echoSeparation) echoes.emplace_back(), most = -1;
    Echo& echo = echoes.back();
    if (power > most) most = power, echo.ray = ray;
    echo.range += power * distance;
    echo.intensity += share;
    echo.power += power;
    last = distance;
  }
  for (Echo& echo : echoes) {
    if (!(echo.power > 0)) continue;
    echo.range /= echo.power;
    echo.intensity = std::min(echo.intensity, 1.0);
  }
  return echoes;
}

void detect(const Properties& properties, std::optional<uint64_t> seed, uint32_t firing, std::vector<Echo>& echoes) {
  // Infinite if the rated range is, so that every signal above zero is detected.
  const double signalOfPower = properties.ratedRange * properties.ratedRange / kRatedReflectance;
  size_t detected = 0;
  for (size_t i = 0; i < echoes.size(); ++i) {
    Echo echo = echoes[i];
    const dvec2 noise = seed ? normals(*seed, firing, static_cast<uint32_t>(i)) : dvec2(0);
    echo.range += noise.x * properties.rangeNoise;
    if (const double step = properties.rangeResolution; step > 0) echo.range = std::round(echo.range / step) * step;
    if (!(echo.power > 0) || !(echo.power * signalOfPower + noise.y * kSignalNoise >= kSignalThreshold)) continue;
    if (!(echo.range > 0 && echo.range >= properties.minRange && echo.range <= properties.maxRange)) continue;
    echo.number = static_cast<uint8_t>(std::min<size_t>(detected, UINT8_MAX));
    echoes[detected++] = echo;
  }
  echoes.resize(detected);
}

void select(Returns returns, std::vector<Echo>& echoes) {
  if (returns == Returns::All || echoes.size() < 2) return;
  // By the power, because signals are all infinite if the rated range is.
  const auto byStrength = [](const Echo& a, const Echo& b) { return a.power < b.power; };
  const auto strongestOf = [&](size_t except) {
    size_t best = except == 0 ? 1 : 0;
    for (size_t i = best + 1; i < echoes.size(); ++i)
      if (i != except && byStrength(echoes[best], echoes[i])) best = i;
    return best;
  };
  const size_t last = echoes.size() - 1, strongest = strongestOf(echoes.size());
  if (returns == Returns::First) echoes = {echoes.front()};
  if (returns == Returns::Last) echoes = {echoes.back()};
  if (returns == Returns::Strongest) echoes = {echoes[strongest]};
  if (returns != Returns::Dual) return;
  // As Velodyne's sensors: the strongest and the last, or the two strongest if these are the same.
  const size_t other = strongest == last ? strongestOf(last) : last;
  echoes = {echoes[std::min(strongest, other)], echoes[std::max(strongest, other)]};
}

}  // namespace latelight::lidar
