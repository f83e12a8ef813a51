#include "render/exposure/camera_samples.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <numeric>

namespace latelight::render {

namespace {

constexpr double kPi = glm::pi<double>();

glm::dvec2 onDisk(glm::dvec2 square) {
  const glm::dvec2 p = 2.0 * square - 1.0;
  if (p == glm::dvec2(0)) return p;
  const bool wide = std::abs(p.x) > std::abs(p.y);
  const double radius = wide ? p.x : p.y;
  const double angle = wide ? kPi / 4 * (p.y / p.x) : kPi / 2 - kPi / 4 * (p.x / p.y);
  return radius * glm::dvec2(std::cos(angle), std::sin(angle));
}

// A regular polygon with its corners on the unit circle, as a fan of triangles around its center.
glm::dvec2 onPolygon(glm::dvec2 square, uint32_t corners, double rotation) {
  const double fan = square.x * corners, first = std::min(std::floor(fan), corners - 1.0), share = fan - first;
  const auto corner = [&](double i) {
    const double angle = kPi / 2 + rotation + 2 * kPi * i / corners;
    return glm::dvec2(std::cos(angle), std::sin(angle));
  };
  return std::sqrt(square.y) * ((1 - share) * corner(first) + share * corner(first + 1));
}

// Returns a step through `count` cells that visits all of them and is near the golden section.
size_t stepThrough(size_t count) {
  auto step = static_cast<size_t>(std::llround(0.618033988749895 * static_cast<double>(count)));
  while (std::gcd(step, count) != 1) ++step;
  return step;
}

double fraction(double x) {
  return x - std::floor(x);
}

}  // namespace

std::vector<CameraSample> pixelSamples(const Settings& settings) {
  const uint32_t side = settings.aa.superSampling;
  std::vector<CameraSample> samples;
  for (uint32_t i = 0; i < side * side; ++i) {
    const glm::vec2 cell(static_cast<float>(i % side), static_cast<float>(i / side));
    samples.push_back({.jitter = (cell + 0.5f) / static_cast<float>(side) - 0.5f});
  }
  return samples;
}

glm::dvec2 aperturePoint(const Settings& settings, glm::dvec2 square) {
  if (settings.apertureBlades == 0) return onDisk(square);
  return onPolygon(square, settings.apertureBlades, settings.apertureRotation);
}

std::vector<CameraSample> exposureSamples(const Settings& settings) {
  constexpr double kPlastic = 1.324717957244746;
  const std::vector<CameraSample> pixel = pixelSamples(settings);
  const size_t cells = pixel.size(), rounds = (settings.cameraSamples + cells - 1) / cells, count = rounds * cells;
  const size_t step = stepThrough(cells);
  std::vector<CameraSample> samples;
  for (size_t i = 0; i < count; ++i) {
    const auto n = static_cast<double>(i);
    CameraSample& sample = samples.emplace_back(pixel[(i * step + i / cells) % cells]);
    sample.seconds = ((n + 0.5) / static_cast<double>(count) - 0.5) * settings.shutter;
    if (count > 1)
      sample.lens = aperturePoint(settings, {fraction(0.5 + n / kPlastic), fraction(0.5 + n / (kPlastic * kPlastic))});
  }
  return samples;
}

}  // namespace latelight::render
