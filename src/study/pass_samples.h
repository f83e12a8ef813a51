// Repeated measurements: frames pass by pass, medians and spreads.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "render/submit/renderer.h"

namespace latelight::study {

using Milliseconds = std::vector<double>;  // of repeated measurements

double median(const Milliseconds& samples);  // 0 without samples
// Half of the samples lie within this many per cent of the median, together.
double spread(const Milliseconds& samples);

// Each frame's passes by name, in the order of their first appearance.
struct PassSamples {
  std::vector<std::string> names;
  std::map<std::string, Milliseconds> of;
  std::map<std::string, uint64_t> wholeBytes;  // of one frame, as graph::PassTime has them
  Milliseconds all;

  void add(std::span<const graph::PassTime> passes);
};

// The camera, turned by so many radians about the vertical axis through a point.
scene::Camera turned(scene::Camera camera, double angle, glm::dvec3 middle);

// Seconds of work before anything is measured. GPUs lower their clocks while they rest, or wait for a scene to be made:
// an H200 goes from 1980 MHz to 345 within two seconds, and takes up to half a second of work to be back.
constexpr double kWarmUp = 0.5;

// So many frames with each of some settings, left on the device, after some that warm up. They take turns, so
// that whatever else the machine does falls on all of them. The camera turns a little from frame to frame: what is kept
// for a later frame is what does not depend on the view.
std::vector<PassSamples> measureInTurn(render::Renderer& renderer, const scene::Camera& camera,
                                       const render::Moment& moment, std::span<const render::Settings> settings,
                                       uint32_t frames);

}  // namespace latelight::study
