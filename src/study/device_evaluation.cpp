#include "study/device_evaluation.h"

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "study/evaluation_push.h"
#include "vk/commands.h"

namespace latelight::study {

namespace {

constexpr size_t kBatch = size_t{1} << 19;
constexpr uint32_t kGroup = 64;  // local_size of evaluation.glsl

void waitForHost(VkCommandBuffer commands) {
  vk::recordMemoryBarrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                          VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
}

}  // namespace

DeviceEvaluation::DeviceEvaluation(const Options& options)
    : device_({.selector = options.device, .validation = options.validation}),
      inputs_(device_, {.size = kBatch * sizeof(shared::vec4), .kind = vk::MemoryKind::Upload, .name = "study inputs"}),
      outputs_(device_,
               {.size = kBatch * sizeof(shared::vec4), .kind = vk::MemoryKind::Readback, .name = "study outputs"}) {}

vk::Pipeline DeviceEvaluation::make(const char* shader, const std::vector<vk::Constant>& constants) {
  return vk::makePipeline(
      device_,
      vk::ComputeDesc{
          .shader = shader, .constants = constants, .pushBytes = sizeof(shared::EvaluationPush), .name = shader});
}

std::vector<shared::vec4> DeviceEvaluation::run(const vk::Pipeline& pipeline, std::span<const shared::vec4> inputs,
                                                const shared::Projection& projection) {
  std::vector<shared::vec4> results(inputs.size());
  for (size_t first = 0; first < inputs.size(); first += kBatch) {
    const size_t count = std::min(kBatch, inputs.size() - first);
    std::memcpy(inputs_.mapped(), &inputs[first], count * sizeof(shared::vec4));
    const shared::EvaluationPush push{inputs_.address(), outputs_.address(), static_cast<uint32_t>(count), projection};
    vk::DescriptorPool pool(device_);
    device_.submitAndWait([&](VkCommandBuffer buffer) {
      vk::Commands commands(buffer, pool);
      commands.bind(pipeline, std::initializer_list<vk::BoundImage>{}, push);
      commands.dispatch(push.count, 1, 1, kGroup, 1);
      waitForHost(buffer);
    });
    std::memcpy(&results[first], outputs_.mapped(), count * sizeof(shared::vec4));
  }
  return results;
}

void DeviceEvaluation::expectSilence() {
  for (const std::string& message : device_.validationMessages())
    fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
}

}  // namespace latelight::study
