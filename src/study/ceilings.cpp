#include "study/ceilings.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "graph/graph.h"
#include "render/base/pass.h"
#include "study/ceilings_push.h"

namespace latelight::study {

namespace {

constexpr uint32_t kCeilingGroup = 256;  // local_size of the shaders

// Several times the size of the caches of the largest devices.
VkDeviceSize copiedBytes(const vk::Device& device) {
  return VkDeviceSize{device.isCpu() ? 128u : 256u} << 20;
}

void addCopy(const render::Builder& b) {
  const VkDeviceSize size = copiedBytes(b.device);
  const graph::BufferId source = b.graph.create(vk::BufferDesc{.size = size, .name = "copied"});
  const graph::BufferId target = b.graph.create(vk::BufferDesc{.size = size, .name = "copy"});
  render::addClear(b, graph::Stage::Upload, "clear", {source});
  render::addCompute(b,
                     {.stage = graph::Stage::Output,
                      .name = "copy",
                      .shader = "copy_ceiling.comp",
                      .bindings = render::Bindings(b.device),
                      .size = {static_cast<uint32_t>(size / sizeof(shared::uvec4) / shared::kCopyChunk), 1, 1},
                      .buffers = {{source, graph::Use::StorageRead}, {target, graph::Use::StorageWrite}},
                      .groupX = kCeilingGroup,
                      .groupY = 1},
                     [=](graph::Context& c) {
                       return shared::CopyPush{c.buffer(source).address(), c.buffer(target).address()};
                     });
  b.graph.exports(target, graph::Use::StorageRead);
}

struct Arithmetic {
  uint32_t invocations, rounds;
  double multiplyAdds() const {
    return double(invocations) * rounds * shared::kArithmeticSteps * shared::kArithmeticChains;
  }
};

// About a millisecond of work for the largest devices.
Arithmetic arithmeticOf(const vk::Device& device) {
  return {device.isCpu() ? 1u << 15 : 1u << 20, 512};
}

void addArithmetic(const render::Builder& b) {
  const Arithmetic work = arithmeticOf(b.device);
  const graph::BufferId results =
      b.graph.create(vk::BufferDesc{.size = work.invocations * sizeof(float), .name = "results"});
  render::addCompute(b,
                     {.stage = graph::Stage::Output,
                      .name = "arithmetic",
                      .shader = "arithmetic_ceiling.comp",
                      .bindings = render::Bindings(b.device),
                      .size = {work.invocations, 1, 1},
                      .buffers = {{results, graph::Use::StorageWrite}},
                      .groupX = kCeilingGroup,
                      .groupY = 1},
                     [=](graph::Context& c) {
                       return shared::ArithmeticPush{c.buffer(results).address(), 0.999f, 0.001f, work.rounds};
                     });
  b.graph.exports(results, graph::Use::StorageRead);
}

}  // namespace

Ceilings measureCeilings(vk::Device& device, uint32_t runs) {
  graph::Executor executor(device);
  graph::Graph graph(executor);
  addCopy({device, graph});
  addArithmetic({device, graph});
  const graph::Plan plan = graph.compile();
  double copy = std::numeric_limits<double>::infinity(), arithmetic = copy;  // milliseconds
  for (uint32_t run = 0; run <= runs; ++run) {
    executor.run(graph, plan);
    if (executor.times().empty())
      fail(ExitCode::NoDevice, "{} has no timestamps to measure with; choose another --device", device.info().name);
    for (const graph::PassTime& pass : executor.times()) {
      if (pass.name == "copy") copy = std::min(copy, pass.milliseconds);
      if (pass.name == "arithmetic") arithmetic = std::min(arithmetic, pass.milliseconds);
    }
  }
  return {2e3 * static_cast<double>(copiedBytes(device)) / copy,
          1e3 * arithmeticOf(device).multiplyAdds() / arithmetic};
}

void addCopyCells(std::vector<Cell>& row, const Ceilings& ceilings, uint64_t trafficBytes, double milliseconds) {
  if (trafficBytes == 0) {
    row.insert(row.end(), 2, Cell(""));
    return;
  }
  const auto bytes = static_cast<double>(trafficBytes);
  row.insert(row.end(), {1e-6 * bytes, 1e5 * bytes / (ceilings.copiedBytes * milliseconds)});
}

std::string toText(const Ceilings& ceilings) {
  const auto rate = [](double value) {
    return value < 1e12 ? fmt::format("{:#.3g} G", 1e-9 * value) : fmt::format("{:#.3g} T", 1e-12 * value);
  };
  return fmt::format("copies {}B/s, {} multiply-adds per second", rate(ceilings.copiedBytes),
                     rate(ceilings.multiplyAdds));
}

nlohmann::ordered_json toJson(const Ceilings& ceilings) {
  return {{"copied bytes per second", ceilings.copiedBytes}, {"multiply-adds per second", ceilings.multiplyAdds}};
}

}  // namespace latelight::study
