// The headers that are valid GLSL, HLSL and C++: the device runs them compiled from GLSL and from HLSL, and both agree
// with the host's C++.
#include <gtest/gtest.h>

#include <cstring>

#include "gpu_math/spirv.h"
#include "shared/portable_cases.h"
#include "shared/random.h"
#include "test_device.h"
#include "vk/commands.h"
#include "vk/resources.h"

namespace latelight::shared {
namespace {

constexpr uint kCount = 4096;  // sets of arguments: kColumns of portable.hlsl
constexpr uint kGroup = 64;    // the shaders' workgroup

struct Case {
  std::string name;
  float relative, absolute;
};

// For the cases of an encoding: Vulkan allows 2.5 ULP for inversesqrt and division, and far more for atan2 than devices
// show. It also lets devices fuse products into sums, and the discs of spheremap and lambert take the root of 1 minus a
// number near 1 at their rim, which then differs more.
Case caseOf(const std::string& part, const std::string& encoding) {
  const bool isDisc = encoding.starts_with("spheremap") || encoding == "lambert";
  return {part + encoding, 0.0f, encoding.starts_with("spherical") ? 4e-6f : isDisc ? 2e-6f : 6e-7f};
}

std::vector<Case> cases() {
  std::vector<Case> list;
#define ENCODING(name, index)                                                        \
  for (const char* part : {"encodeFloat_", "encode8_", "decode16_", "decodeFloat_"}) \
    list.push_back(caseOf(part, #name));
  LATELIGHT_NORMALS(ENCODING)
#undef ENCODING
#define ENTRY(name, relative, absolute, result) list.push_back({#name, relative, absolute});
  PORTABLE_CASES(ENTRY)
#undef ENTRY
  return list;
}

// Returns a direction, one in eight along an axis or a diagonal, where encodings have their seams.
vec3 someDirection(Random& random) {
  if (random.uniform() >= 0.125f) return random.direction();
  const auto step = [&] { return std::floor(random.uniform(-1.0f, 2.0f)); };
  const vec3 d(step(), step(), step());
  return d == vec3(0.0f, 0.0f, 0.0f) ? vec3(0.0f, 0.0f, 1.0f) : normalize(d);
}

PortableArguments someArguments(Random& random) {
  const auto code = [&] { return static_cast<float>(random.bits() % 65536) / 65535.0f; };
  const auto wide = [&] { return random.logUniform(1e-3f, 1e3f); };
  PortableArguments a;
  a.n = vec4(someDirection(random), random.uniform(0.01f, 0.95f));
  a.c = vec4(code(), code(), code(), random.uniform());
  a.w = vec4(wide(), wide(), wide(), wide());
  a.k = uvec4(random.bits(), random.bits(), random.bits(), random.bits());
  return a;
}

// A compute pipeline with two bound storage buffers, as in an engine without buffer addresses.
class BoundShader {
 public:
  BoundShader(vk::Device& device, const std::string& spirv, const vk::Buffer& in, const vk::Buffer& out)
      : device_(device) {
    makeLayouts();
    makePipeline(test::readSpirv(spirv));
    bind(in, out);
  }

  void run(uint columns, uint rows) {
    device_.submitAndWait([&](VkCommandBuffer commands) {
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_.get(), 0, 1, &set_, 0, nullptr);
      vkCmdDispatch(commands, columns / kGroup, rows, 1);
      vk::recordMemoryBarrier(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                              VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
    });
  }

 private:
  void makeLayouts() {
    VkDescriptorSetLayoutBinding bindings[2]{};
    for (uint32_t i = 0; i < 2; ++i)
      bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo setInfo{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    setInfo.bindingCount = 2;
    setInfo.pBindings = bindings;
    VkDescriptorSetLayout set = VK_NULL_HANDLE;
    VK_CHECK(vkCreateDescriptorSetLayout(device_.get(), &setInfo, nullptr, &set));
    setLayout_ = vk::Handle<VkDescriptorSetLayout>(device_, set);
    VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    info.setLayoutCount = 1;
    info.pSetLayouts = &set;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VK_CHECK(vkCreatePipelineLayout(device_.get(), &info, nullptr, &layout));
    layout_ = vk::Handle<VkPipelineLayout>(device_, layout);
  }

  void makePipeline(const std::vector<uint32_t>& code) {
    VkShaderModuleCreateInfo create{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    create.codeSize = code.size() * 4;
    create.pCode = code.data();
    VkShaderModule module = VK_NULL_HANDLE;
    VK_CHECK(vkCreateShaderModule(device_.get(), &create, nullptr, &module));
    const vk::Handle<VkShaderModule> owned(device_, module);
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    info.layout = layout_.get();
    VkPipeline pipeline = VK_NULL_HANDLE;
    VK_CHECK(vkCreateComputePipelines(device_.get(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline));
    pipeline_ = vk::Handle<VkPipeline>(device_, pipeline);
  }

  void bind(const vk::Buffer& in, const vk::Buffer& out) {
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 2};
    VkDescriptorPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    poolInfo.maxSets = 1;
    poolInfo.poolSizeCount = 1;
    poolInfo.pPoolSizes = &size;
    VkDescriptorPool pool = VK_NULL_HANDLE;
    VK_CHECK(vkCreateDescriptorPool(device_.get(), &poolInfo, nullptr, &pool));
    pool_ = vk::Handle<VkDescriptorPool>(device_, pool);
    const VkDescriptorSetLayout layout = setLayout_.get();
    VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    info.descriptorPool = pool;
    info.descriptorSetCount = 1;
    info.pSetLayouts = &layout;
    VK_CHECK(vkAllocateDescriptorSets(device_.get(), &info, &set_));
    const VkDescriptorBufferInfo buffers[] = {{in.get(), 0, VK_WHOLE_SIZE}, {out.get(), 0, VK_WHOLE_SIZE}};
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set_;
    write.descriptorCount = 2;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = buffers;
    vkUpdateDescriptorSets(device_.get(), 1, &write, 0, nullptr);
  }

  vk::Device& device_;
  vk::Handle<VkDescriptorSetLayout> setLayout_;
  vk::Handle<VkPipelineLayout> layout_;
  vk::Handle<VkPipeline> pipeline_;
  vk::Handle<VkDescriptorPool> pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

constexpr const char* kLanguages[] = {"glsl", "hlsl"};

struct Results {
  std::vector<PortableArguments> arguments;
  std::vector<vec4> byLanguage[2];
  std::vector<std::string> messages;

  Results() {
    vk::Device device({.selector = test::testDevice(), .validation = true});
    Random random(3);
    for (uint i = 0; i < kCount; ++i) arguments.push_back(someArguments(random));
    const size_t rows = cases().size();
    const vk::Buffer in(device, {.size = kCount * sizeof(PortableArguments), .kind = vk::MemoryKind::Upload});
    std::memcpy(in.mapped(), arguments.data(), in.size());
    for (size_t l = 0; l < std::size(kLanguages); ++l) {
      const vk::Buffer out(device, {.size = rows * kCount * sizeof(vec4), .kind = vk::MemoryKind::Readback});
      BoundShader(device, std::string("gpu_math_portable_") + kLanguages[l], in, out).run(kCount, uint(rows));
      byLanguage[l].assign(out.as<vec4>(), out.as<vec4>() + rows * kCount);
    }
    messages = device.validationMessages();
  }
};

const Results& results() {
  static const Results once;
  return once;
}

class Portable : public testing::TestWithParam<std::tuple<size_t, uint>> {};

TEST_P(Portable, AgreesWithHost) {
  const auto [language, index] = GetParam();
  const Case bounds = cases()[index];
  double worst = 0;
  bool varies = false;
  std::string where;
  for (uint i = 0; i < kCount; ++i) {
    const vec4 device = results().byLanguage[language][size_t{index} * kCount + i];
    const vec4 host = evaluatePortable(index, results().arguments[i]);
    varies |= device != results().byLanguage[language][size_t{index} * kCount];
    for (int c = 0; c < 4; ++c) {
      if (device[c] == host[c] || (std::isnan(device[c]) && std::isnan(host[c]))) continue;
      double share =
          std::abs(double{device[c]} - host[c]) / (double{bounds.relative} * std::abs(host[c]) + bounds.absolute);
      if (std::isnan(share)) share = INFINITY;
      if (share <= worst) continue;
      worst = share;
      where = "arguments " + std::to_string(i) + ", component " + std::to_string(c) + ": device " +
              std::to_string(device[c]) + ", host " + std::to_string(host[c]);
    }
  }
  EXPECT_LE(worst, 1.0) << where;
  EXPECT_TRUE(varies) << "a function that is the same for all arguments would agree with anything";
  RecordProperty("shareOfBound", std::to_string(worst));
}

INSTANTIATE_TEST_SUITE_P(Shared, Portable,
                         testing::Combine(testing::Range(size_t{0}, std::size(kLanguages)),
                                          testing::Range(0u, static_cast<uint>(cases().size()))),
                         [](const auto& info) {
                           return std::string(kLanguages[std::get<0>(info.param)]) + "_" +
                                  cases()[std::get<1>(info.param)].name;
                         });

TEST(PortableOnDevice, ValidationIsSilent) {
  for (const std::string& message : results().messages) ADD_FAILURE() << message;
}

}  // namespace
}  // namespace latelight::shared
