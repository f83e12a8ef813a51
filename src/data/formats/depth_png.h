// Depth as 16-bit integers, and its encoding as PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "output/aov.h"

namespace latelight::data {

// Quantizes depth or distance to the nearest step. The result is 0 for the background and for surfaces nearer than half
// a step or farther than 65,535 steps.
std::vector<uint16_t> depthSteps(const output::AovImage& depth, double stepsPerMetre);
std::vector<std::byte> encodeDepthPng(const output::AovImage& depth, double stepsPerMetre);
// Describes the contents of such a file, as FormatFile::contents.
std::string depthPngContents(output::Aov aov, double stepsPerMetre);

}  // namespace latelight::data
