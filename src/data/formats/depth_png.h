// Depth in steps of 16 bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "output/aov.h"

namespace latelight::data {

// Depth or distance, rounded to the nearest step. 0: nothing is there, or it is nearer than half a step or farther than
// 65,535 steps.
std::vector<uint16_t> depthSteps(const output::AovImage& depth, double stepsPerMetre);
std::vector<std::byte> encodeDepthPng(const output::AovImage& depth, double stepsPerMetre);

}  // namespace latelight::data
