// The echoes of a beam: what its rays hit, merged along the beam, and which echoes a noisy receiver detects.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lidar/sensor.h"

namespace latelight::lidar {

enum class Returns : uint8_t { Strongest, First, Last, Dual, All };
// Throws Error(Usage) that lists the names if there is no such value.
Returns returnsNamed(std::string_view name);

struct Echo {
  double range = 0;      // meters: the mean over the rays, weighted by the light that they return
  double intensity = 0;  // the share of the beam that the surfaces return
  double power = 0;      // received: 1 from a white surface that fills the beam and faces the sensor at 1 m
  uint32_t ray = 0;      // the ray that returns the most light
  uint8_t number = 0;    // among the detected echoes of the firing, from the nearest
};

// Returns the offsets of a beam's rays in radians, horizontal and vertical. Each ray stands for an equal share of the
// energy of a Gaussian beam: Vogel's spiral over the quantiles of its radius.
std::vector<glm::dvec2> beamOffsets(const Properties& properties, uint32_t rays);

// Returns the directions of a beam's rays.
void beamRays(const glm::dvec3& direction, std::span<const glm::dvec2> offsets, std::span<glm::dvec3> rays);

// Merges the hits of a beam's rays into echoes, from the nearest. Distances of rays that hit nothing are infinite.
std::vector<Echo> echoesOf(const Properties& properties, std::span<const float> distances,
                           std::span<const float> intensities);

// Keeps the echoes that the receiver detects, with noise of ranges and signals by `seed` and the index of the firing;
// null: without noise.
void detect(const Properties& properties, std::optional<uint64_t> seed, uint32_t firing, std::vector<Echo>& echoes);

// Keeps the echoes that the sensor reports.
void select(Returns returns, std::vector<Echo>& echoes);

}  // namespace latelight::lidar
