// The tables by which rays choose bright directions of environments (shared/rays.h), in device memory.
#pragma once

#include <span>
#include <vector>

#include "graph/graph.h"
#include "render/gpu_scene/gpu_environment.h"
#include "shared/rays.h"

namespace latelight::render {

// Returns the cumulative distributions (shared/rays.h) of cells of these mean brightnesses, row by row. Cells get at
// least a thousandth of the mean density, so that no direction is left out.
std::vector<uint32_t> environmentTable(std::span<const float> brightness);

// Runs graphs on the device that measure the cells, waits for them, and returns the tables of all environments, one
// after the other.
vk::Buffer makeEnvironmentCells(vk::Device& device, graph::Executor& executor, const GpuEnvironment& environments);

}  // namespace latelight::render
