// Repeated measurements of frames, pass by pass, with medians and spreads.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "render/submit/renderer.h"

namespace latelight::study {

using Milliseconds = std::vector<double>;  // repeated measurements

double median(const Milliseconds& samples);  // 0 without samples
// Returns the width of the interval that contains the middle half of the samples, in percent of the median.
double spread(const Milliseconds& samples);

// The times of each pass over all frames, by name, in the order of first appearance.
struct PassSamples {
  std::vector<std::string> names;
  std::map<std::string, Milliseconds> of;
  std::map<std::string, uint64_t> trafficBytes;  // per frame, as in graph::PassTime
  Milliseconds all;

  void add(std::span<const graph::PassTime> passes);
};

// Rotates the camera by `angle` radians about the vertical axis through a point.
scene::Camera turned(scene::Camera camera, double angle, glm::dvec3 middle);

// Seconds of work before any measurement. GPUs lower their clocks while they are idle or wait for a scene to load: an
// H200 drops from 1980 MHz to 345 MHz within two seconds, and needs up to half a second of work to recover.
constexpr double kWarmUp = 0.5;

// Renders this many frames with each of the settings after a warm-up; the results stay on the device. The settings
// alternate, so that other load on the machine affects all of them equally. The camera turns a little between frames,
// so that only view-independent data are reused from earlier frames.
std::vector<PassSamples> measureInterleaved(render::Renderer& renderer, const scene::Camera& camera,
                                            const render::SceneState& moment,
                                            std::span<const render::Settings> settings, uint32_t frames);

}  // namespace latelight::study
