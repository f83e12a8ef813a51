#pragma once

#include <cstddef>
#include <vector>

#include "output/aov.h"

namespace latelight::data {

// Depth or distance as PNG of 16 bits, rounded to the nearest step. 0: nothing is there, or it is nearer than half a
// step or farther than 65,535 steps.
std::vector<std::byte> encodeDepthPng(const output::AovImage& depth, double stepsPerMetre);

}  // namespace latelight::data
