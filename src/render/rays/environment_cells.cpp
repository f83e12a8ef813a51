#include "render/rays/environment_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

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

// Writes the fraction of `shares` that comes before each of them, times 2^32. Each of them has a part of that range.
// Returns their sum.
double writeCumulative(std::span<const double> shares, std::span<uint32_t> starts) {
  const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
  const double units = 0x1p32 - static_cast<double>(shares.size());  // one of the others goes to each element
  double before = 0;
  for (size_t i = 0; i < shares.size(); ++i) {
    starts[i] = static_cast<uint32_t>(i + static_cast<uint64_t>(std::min(before / total, 1.0) * units));
    before += shares[i];
  }
  return total;
}

}  // namespace

std::vector<uint32_t> environmentTable(std::span<const float> brightness) {
  using shared::kEnvironmentColumns, shared::kEnvironmentRows;
  double total = 0;
  for (size_t i = 0; i < kCells; ++i)
    total += std::max(0.0, double{brightness[i]}) * solidAngle(i / kEnvironmentColumns);
  const double least = 1e-3 * (total > 0 ? total / (4 * std::numbers::pi) : 1);
  std::vector<uint32_t> table(shared::kEnvironmentTableBytes / sizeof(uint32_t));
  std::vector<double> rows(kEnvironmentRows), columns(kEnvironmentColumns);
  for (size_t row = 0; row < kEnvironmentRows; ++row) {
    const std::span<const float> cells = brightness.subspan(row * kEnvironmentColumns, kEnvironmentColumns);
    for (size_t i = 0; i < cells.size(); ++i) columns[i] = std::max(0.0, double{cells[i]}) + least;
    const std::span<uint32_t> starts =
        std::span(table).subspan(kEnvironmentRows + row * kEnvironmentColumns, kEnvironmentColumns);
    rows[row] = writeCumulative(columns, starts) * solidAngle(row);
  }
  writeCumulative(rows, std::span(table).first(kEnvironmentRows));
  return table;
}

namespace {

// Returns the table of an environment.
std::vector<uint32_t> measuredTable(vk::Device& device, graph::Executor& executor, const vk::BoundImage& radiance) {
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
  return environmentTable(std::span(done.buffer(result).as<const float>(), kCells));
}

}  // namespace

vk::Buffer makeEnvironmentCells(vk::Device& device, graph::Executor& executor, const GpuEnvironment& environments) {
  constexpr uint64_t kTable = shared::kEnvironmentTableBytes;
  vk::Buffer buffer(device, {.size = environments.count() * kTable, .name = "environment cells"});
  for (uint32_t i = 0; i < environments.count(); ++i) {
    const std::vector<uint32_t> table = measuredTable(device, executor, environments.radiance(i));
    vk::Uploader uploader(device);
    uploader.upload(buffer, std::as_bytes(std::span(table)), i * kTable);
    uploader.flush();
  }
  return buffer;
}

}  // namespace latelight::render
