// Runs a shader that only tests use.
#pragma once

#include <string>

#include "gpu_math/spirv.h"
#include "vk/commands.h"
#include "vk/resources.h"

namespace latelight::test {

// Dispatches enough workgroups of `group` by 1 invocations to cover `width` by `height`, and waits. The host may then
// read what the shader wrote. `name`: as for readSpirv().
template <typename Push>
void runShader(vk::Device& device, const std::string& name, const Push& push, uint32_t width, uint32_t height,
               uint32_t group) {
  const vk::Pipeline pipeline = vk::makePipeline(device, vk::ComputeDesc{.name = name, .code = readSpirv(name)});
  vk::DescriptorPool pool(device);
  device.submitAndWait([&](VkCommandBuffer buffer) {
    vk::Commands commands(buffer, pool);
    commands.bind(pipeline, std::initializer_list<vk::BoundImage>{}, push);
    commands.dispatch(width, height, 1, group, 1);
    vk::recordMemoryBarrier(buffer, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                            VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  });
}

}  // namespace latelight::test
