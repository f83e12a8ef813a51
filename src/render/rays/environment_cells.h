// The table by which rays choose bright directions of an environment (shared/rays.h), in device memory.
#pragma once

#include <span>
#include <vector>

#include "graph/graph.h"
#include "render/gpu_scene/gpu_environment.h"
#include "shared/rays.h"

namespace latelight::render {

// Returns the alias table of cells of these mean brightnesses, row by row. Cells get at least a thousandth of the mean
// density, so that no direction is left out.
std::vector<shared::EnvironmentCell> aliasTable(std::span<const float> brightness);

// Runs a graph on the device that measures the cells, waits for it, and returns shared::EnvironmentCell[].
vk::Buffer makeEnvironmentCells(vk::Device& device, graph::Executor& executor, const GpuEnvironment& environment);

}  // namespace latelight::render
