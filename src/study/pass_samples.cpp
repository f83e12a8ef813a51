#include "study/pass_samples.h"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>

#include "base/stopwatch.h"

namespace latelight::study {

namespace {

// Interpolates linearly between the two nearest samples, so that the median of an even number is the mean of the two
// middle ones (definition 7 of Hyndman and Fan 1996, Sample Quantiles in Statistical Packages).
double quantile(Milliseconds samples, double at) {
  if (samples.empty()) return 0;
  std::ranges::sort(samples);
  const double position = at * static_cast<double>(samples.size() - 1);
  const auto below = static_cast<size_t>(position);
  const size_t above = std::min(below + 1, samples.size() - 1);
  return std::lerp(samples[below], samples[above], position - static_cast<double>(below));
}

}  // namespace

double median(const Milliseconds& samples) {
  return quantile(samples, 0.5);
}

double spread(const Milliseconds& samples) {
  const double middle = median(samples);
  return middle > 0 ? 100 * (quantile(samples, 0.75) - quantile(samples, 0.25)) / middle : 0;
}

void PassSamples::add(std::span<const graph::PassTime> passes) {
  std::map<std::string, double> frame;
  double sum = 0;
  for (const graph::PassTime& pass : passes) {
    if (!of.contains(pass.name)) names.push_back(pass.name);
    of[pass.name];
    trafficBytes[pass.name] = pass.trafficBytes;
    frame[pass.name] += pass.milliseconds;
    sum += pass.milliseconds;
  }
  for (const auto& [name, milliseconds] : frame) of[name].push_back(milliseconds);
  all.push_back(sum);
}

scene::Camera turned(scene::Camera camera, double angle, glm::dvec3 middle) {
  const glm::dmat4 there = glm::translate(glm::dmat4(1), middle);
  const glm::dmat4 turn = glm::rotate(there, angle, glm::dvec3(0, 0, 1));
  camera.toWorld = glm::translate(turn, -middle) * camera.toWorld;
  return camera;
}

std::vector<PassSamples> measureInterleaved(render::Renderer& renderer, const scene::Camera& camera,
                                            const render::SceneState& moment,
                                            std::span<const render::Settings> settings, uint32_t frames) {
  constexpr double kTurn = 1e-3;  // radians per frame
  const auto render = [&](uint32_t frame, const render::Settings& with) {
    const scene::Camera now = turned(camera, frame * kTurn, glm::dvec3(camera.toWorld[3]));
    return renderer.submit({&now, 1}, with, moment, render::Results::OnDevice).take().statistics.passTimes;
  };
  for (const render::Settings& each : settings) render(0, each);  // creates pipelines and caches of the scene
  const Stopwatch stopwatch;
  while (stopwatch.seconds() < kWarmUp)
    for (const render::Settings& each : settings) render(0, each);
  std::vector<PassSamples> samples(settings.size());
  for (uint32_t frame = 1; frame <= frames; ++frame)
    for (size_t i = 0; i < settings.size(); ++i) samples[i].add(render(frame, settings[i]));
  return samples;
}

}  // namespace latelight::study
