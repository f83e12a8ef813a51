#include "render/rays/environment_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/base/readback.h"
#include "render/rays/environment_push.h"

namespace latelight::render {

namespace {

constexpr size_t kCells = size_t{shared::kEnvironmentColumns} * shared::kEnvironmentRows;

// Returns the solid angle of the cells of a row.
double solidAngle(size_t row) {
  constexpr double kStep = std::numbers::pi / shared::kEnvironmentRows;
  return 2 * std::numbers::pi / shared::kEnvironmentColumns *
         (std::cos(static_cast<double>(row) * kStep) - std::cos(static_cast<double>(row + 1) * kStep));
}

}  // namespace

std::vector<shared::EnvironmentCell> aliasTable(std::span<const float> brightness) {
  double total = 0;
  for (size_t i = 0; i < kCells; ++i)
    total += std::max(0.0, double{brightness[i]}) * solidAngle(i / shared::kEnvironmentColumns);
  const double mean = total > 0 ? total / (4 * std::numbers::pi) : 1, least = 1e-3 * mean;
  std::vector<double> shares(kCells);
  double sum = 0;
  for (size_t i = 0; i < kCells; ++i) {
    shares[i] = (std::max(0.0, double{brightness[i]}) + least) * solidAngle(i / shared::kEnvironmentColumns);
    sum += shares[i];
  }
  std::vector<shared::EnvironmentCell> cells(kCells);
  std::vector<uint32_t> small, large;
  for (uint32_t i = 0; i < kCells; ++i) {
    cells[i].density = static_cast<float>(shares[i] / sum / solidAngle(i / shared::kEnvironmentColumns));
    shares[i] *= kCells / sum;
    (shares[i] < 1 ? small : large).push_back(i);
  }
  while (!small.empty() && !large.empty()) {
    const uint32_t low = small.back(), high = large.back();
    small.pop_back();
    cells[low].threshold = static_cast<float>(shares[low]);
    cells[low].alias = high;
    shares[high] -= 1 - shares[low];
    if (shares[high] >= 1) continue;
    large.pop_back();
    small.push_back(high);
  }
  for (const std::vector<uint32_t>* rest : {&small, &large})
    for (const uint32_t i : *rest) cells[i].threshold = 1, cells[i].alias = i;
  return cells;
}

namespace {

// Returns the table of an environment.
std::vector<shared::EnvironmentCell> measuredCells(vk::Device& device, graph::Executor& executor,
                                                   const vk::BoundImage& radiance) {
  graph::Graph graph(executor);
  const Builder b{device, graph};
  const graph::BufferId weights = createResult(b, "environment weights", kCells * sizeof(float), 1).buffer;
  addCompute(
      b,
      {.stage = graph::Stage::Upload,
       .name = "environment weights",
       .shader = "environment_weights.comp",
       .bindings = Bindings(device).outside(radiance),
       .size = {shared::kEnvironmentColumns, shared::kEnvironmentRows, 1},
       .buffers = {{weights, graph::Use::StorageWrite}}},
      [=](graph::Context& context) { return shared::EnvironmentWeightsPush{context.buffer(weights).address()}; });
  const graph::BufferId result = addReadback(b, weights);
  const graph::Submission done = executor.submit(graph, graph.compile());
  done.wait();
  return aliasTable(std::span(done.buffer(result).as<const float>(), kCells));
}

}  // namespace

vk::Buffer makeEnvironmentCells(vk::Device& device, graph::Executor& executor, const GpuEnvironment& environments) {
  const uint64_t table = kCells * sizeof(shared::EnvironmentCell);
  vk::Buffer buffer(device, {.size = environments.count() * table, .name = "environment cells"});
  for (uint32_t i = 0; i < environments.count(); ++i) {
    const std::vector<shared::EnvironmentCell> cells = measuredCells(device, executor, environments.radiance(i));
    vk::Uploader uploader(device);
    uploader.upload(buffer, std::as_bytes(std::span(cells)), i * table);
    uploader.flush();
  }
  return buffer;
}

}  // namespace latelight::render
