#include "vk/pipeline.h"

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "vk/dead_code.h"
#include "vk/interface_check.h"
#include "vk/object_cache.h"
#include "vk/resources.h"
#include "vk/specialize.h"
#include "vk/texel_window.h"

namespace latelight::vk {

namespace {

// Creates one shader stage. Its specialization constants are written into its code, and code that does not run with
// these values is removed: drivers would compile all of it first. The validation layer remembers which modules are
// valid, but would specialize and validate a module with constants again for each pipeline.
class Stage {
 public:
  Stage(Device& device, VkShaderStageFlagBits stage, std::span<const uint32_t> code,
        std::span<const Constant> constants);
  const VkPipelineShaderStageCreateInfo& info() const { return info_; }

 private:
  Handle<VkShaderModule> module_;
  VkPipelineShaderStageCreateInfo info_{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
};

Stage::Stage(Device& device, VkShaderStageFlagBits stage, std::span<const uint32_t> code,
             std::span<const Constant> constants) {
  const std::vector<uint32_t> words = removeDeadCode(specialize(code, constants));
  VkShaderModuleCreateInfo create{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  create.codeSize = std::span(words).size_bytes();
  create.pCode = words.data();
  VkShaderModule module = VK_NULL_HANDLE;
  VK_CHECK(vkCreateShaderModule(device.get(), &create, nullptr, &module));
  module_ = Handle<VkShaderModule>(device, module);
  info_.stage = stage;
  info_.module = module;
  info_.pName = "main";
}

std::vector<Constant> withDeviceConstants(const Device& device, std::span<const Constant> constants) {
  std::vector<Constant> all(constants.begin(), constants.end());
  all.push_back({kCpuDeviceConstant, device.hasCpuShaders() ? 1u : 0u});
  all.push_back({kSubgroupSizeConstant, device.subgroupSize()});
  return all;
}

#ifdef NDEBUG
constexpr bool kDebugBuild = false;
#else
constexpr bool kDebugBuild = true;
#endif

void checkStages(const Device& device, std::span<const CheckedStage> stages, const DeclaredInterface& declared) {
  if (kDebugBuild || device.underValidation()) checkInterface(stages, declared);
}

Pipeline makeLayout(Device& device, std::span<const Binding> bindings, std::span<const std::vector<Binding>> sceneSets,
                    bool loadsTexels) {
  Pipeline made;
  made.bindings.assign(bindings.begin(), bindings.end());
  made.set0 = device.cache().setLayout(made.bindings);
  std::vector<VkDescriptorSetLayout> sets{made.set0};
  for (const std::vector<Binding>& set : sceneSets) sets.push_back(device.cache().setLayout(set));
  if (loadsTexels) {
    const TexelWindow& window = *device.memory().window();
    while (sets.size() < kTexelSet) sets.push_back(device.cache().setLayout({}));
    sets.push_back(window.layout());
    made.texels = window.set();
  }
  const VkPushConstantRange push{VK_SHADER_STAGE_ALL, 0, 128};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.setLayoutCount = static_cast<uint32_t>(sets.size());
  info.pSetLayouts = sets.data();
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &push;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VK_CHECK(vkCreatePipelineLayout(device.get(), &info, nullptr, &layout));
  made.layout = Handle<VkPipelineLayout>(device, layout);
  return made;
}

void finish(Device& device, Pipeline& made, VkPipeline pipeline, VkPipelineBindPoint point, const std::string& name) {
  made.pipeline = Handle<VkPipeline>(device, pipeline);
  made.point = point;
  device.setName(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(pipeline), name.c_str());
}

// All fixed state of a graphics pipeline. It can be neither copied nor moved, because `info` points into it.
struct FixedState {
  explicit FixedState(const GraphicsDesc& desc);
  FixedState(const FixedState&) = delete;
  FixedState& operator=(const FixedState&) = delete;

  std::vector<VkPipelineColorBlendAttachmentState> targets;
  VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
  std::vector<VkVertexInputBindingDescription> vertexBindings;
  std::vector<VkVertexInputAttributeDescription> vertexAttributes;
  VkPipelineVertexInputStateCreateInfo vertices{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  std::vector<VkDynamicState> dynamicStates;
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
};

constexpr VkDynamicState kDynamic[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR, VK_DYNAMIC_STATE_CULL_MODE,
                                       VK_DYNAMIC_STATE_FRONT_FACE};

FixedState::FixedState(const GraphicsDesc& desc) {
  VkPipelineColorBlendAttachmentState target{};
  if (desc.colorWrite)
    target.colorWriteMask =
        VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
  if (desc.alphaOnly) target.colorWriteMask &= VK_COLOR_COMPONENT_A_BIT;
  const auto kept = [](bool under) { return under ? VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA : VK_BLEND_FACTOR_ONE; };
  target.blendEnable = desc.blend != Blend::Replace;
  target.srcColorBlendFactor = target.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
  target.dstColorBlendFactor = kept(desc.blend == Blend::Over);
  target.dstAlphaBlendFactor = kept(desc.blend == Blend::Over || desc.blend == Blend::SumAndOver);
  targets.assign(desc.colors.size(), target);
  // The first color keeps its mask if another is written: lavapipe of Mesa 25 writes none if the first mask is empty.
  for (size_t i = desc.colorsWritten == 0 ? 0 : 1; i < targets.size(); ++i)
    if ((desc.colorsWritten >> i & 1u) == 0) targets[i].colorWriteMask = 0;
  for (const VertexBuffer& buffer : desc.vertexBuffers) {
    const auto binding = static_cast<uint32_t>(vertexBindings.size());
    vertexBindings.push_back(
        {binding, buffer.stride, buffer.perInstance ? VK_VERTEX_INPUT_RATE_INSTANCE : VK_VERTEX_INPUT_RATE_VERTEX});
    for (const VertexAttribute& a : buffer.attributes)
      vertexAttributes.push_back({a.location, binding, a.format, a.offset});
  }
  vertices.vertexBindingDescriptionCount = static_cast<uint32_t>(vertexBindings.size());
  vertices.pVertexBindingDescriptions = vertexBindings.data();
  vertices.vertexAttributeDescriptionCount = static_cast<uint32_t>(vertexAttributes.size());
  vertices.pVertexAttributeDescriptions = vertexAttributes.data();
  rendering.colorAttachmentCount = static_cast<uint32_t>(desc.colors.size());
  rendering.pColorAttachmentFormats = desc.colors.data();
  rendering.depthAttachmentFormat = desc.depth;
  if (hasStencil(desc.depth)) rendering.stencilAttachmentFormat = desc.depth;
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  viewport.viewportCount = 1;
  viewport.scissorCount = 1;
  raster.polygonMode = VK_POLYGON_MODE_FILL;
  raster.lineWidth = 1.0f;
  raster.depthClampEnable = desc.depthClamp;
  samples.rasterizationSamples = static_cast<VkSampleCountFlagBits>(desc.samples);
  depth.depthTestEnable = desc.depth != VK_FORMAT_UNDEFINED;
  depth.depthWriteEnable = depth.depthTestEnable && desc.depthWrite;
  depth.depthCompareOp = desc.depthCompare;
  depth.stencilTestEnable = desc.stencil.has_value();
  depth.front = depth.back = desc.stencil.value_or(VkStencilOpState{});
  blend.attachmentCount = static_cast<uint32_t>(targets.size());
  blend.pAttachments = targets.data();
  dynamicStates.assign(std::begin(kDynamic), std::end(kDynamic));
  if (desc.stencil) dynamicStates.push_back(VK_DYNAMIC_STATE_STENCIL_REFERENCE);
  dynamic.dynamicStateCount = static_cast<uint32_t>(dynamicStates.size());
  dynamic.pDynamicStates = dynamicStates.data();
  info.pNext = &rendering;
  info.pVertexInputState = &vertices;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
}

}  // namespace

VkDescriptorType descriptorType(Binding binding) {
  switch (binding) {
    case Binding::Sampled:
    case Binding::TextureArray:
      return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    case Binding::Storage:
      return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    case Binding::Uniform:
      return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    case Binding::DynamicUniform:
      return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC;
  }
  fail(ExitCode::Internal, "There is no binding of kind {}.", static_cast<int>(binding));
}

Handle<VkDescriptorSetLayout> makeSetLayout(Device& device, std::span<const Binding> bindings) {
  std::vector<VkDescriptorSetLayoutBinding> slots;
  std::vector<VkDescriptorBindingFlags> flags(bindings.size());
  bool isArray = false;
  for (Binding binding : bindings) {
    VkDescriptorSetLayoutBinding slot{};
    slot.binding = static_cast<uint32_t>(slots.size());
    slot.descriptorType = descriptorType(binding);
    slot.descriptorCount = 1;
    slot.stageFlags = VK_SHADER_STAGE_ALL;
    if (binding == Binding::TextureArray) {
      isArray = true;
      slot.descriptorCount = device.maxTextureArray();
      flags[slots.size()] =
          VK_DESCRIPTOR_BINDING_VARIABLE_DESCRIPTOR_COUNT_BIT | VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT;
    }
    slots.push_back(slot);
  }
  VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  info.bindingCount = static_cast<uint32_t>(slots.size());
  info.pBindings = slots.data();
  const VkDescriptorSetLayoutBindingFlagsCreateInfo flagged{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO,
      .bindingCount = info.bindingCount,
      .pBindingFlags = flags.data()};
  if (isArray) {
    info.pNext = &flagged;
    info.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_UPDATE_AFTER_BIND_POOL_BIT;
  }
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  VK_CHECK(vkCreateDescriptorSetLayout(device.get(), &info, nullptr, &layout));
  return Handle<VkDescriptorSetLayout>(device, layout);
}

Pipeline makePipeline(Device& device, const ComputeDesc& desc) {
  const std::span<const uint32_t> code = desc.code.empty() ? shaderCode(desc.shader) : std::span(desc.code);
  const std::vector<Constant> constants = withDeviceConstants(device, desc.constants);
  const CheckedStage checked{desc.code.empty() ? desc.shader.name() : desc.name, code};
  checkStages(
      device, std::span(&checked, 1),
      {.bindings = desc.bindings, .sceneSets = desc.sceneSets, .constants = constants, .pushBytes = desc.pushBytes});
  const auto loads = std::ranges::find(constants, kTexelLoadsConstant, &Constant::id);
  Pipeline made = makeLayout(device, desc.bindings, desc.sceneSets, loads != constants.end() && loads->value != 0);
  const Stage stage(device, VK_SHADER_STAGE_COMPUTE_BIT, code, constants);
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = stage.info();
  info.layout = made.layout.get();
  VkPipeline pipeline = VK_NULL_HANDLE;
  VK_CHECK(vkCreateComputePipelines(device.get(), device.pipelineCache(), 1, &info, nullptr, &pipeline));
  finish(device, made, pipeline, VK_PIPELINE_BIND_POINT_COMPUTE, desc.name);
  return made;
}

Pipeline makePipeline(Device& device, const GraphicsDesc& desc) {
  if (!device.hasGraphics())
    fail(ExitCode::NoDevice, "{} has no graphics pipeline, which \"{}\" is drawn with.", device.info().name, desc.name);
  const std::vector<Constant> constants = withDeviceConstants(device, desc.constants);
  std::vector<CheckedStage> checked{{desc.vertex, shaderCode(desc.vertex)}};
  if (!desc.fragment.empty()) checked.push_back({desc.fragment.name(), shaderCode(desc.fragment)});
  checkStages(
      device, checked,
      {.bindings = desc.bindings, .sceneSets = desc.sceneSets, .constants = constants, .pushBytes = desc.pushBytes});
  Pipeline made = makeLayout(device, desc.bindings, desc.sceneSets, false);
  const Stage vertex(device, VK_SHADER_STAGE_VERTEX_BIT, checked[0].code, constants);
  std::vector<VkPipelineShaderStageCreateInfo> stages{vertex.info()};
  std::optional<Stage> fragment;
  if (!desc.fragment.empty()) {
    fragment.emplace(device, VK_SHADER_STAGE_FRAGMENT_BIT, checked[1].code, constants);
    stages.push_back(fragment->info());
  }
  FixedState state(desc);
  state.info.stageCount = static_cast<uint32_t>(stages.size());
  state.info.pStages = stages.data();
  state.info.layout = made.layout.get();
  VkPipeline pipeline = VK_NULL_HANDLE;
  VK_CHECK(vkCreateGraphicsPipelines(device.get(), device.pipelineCache(), 1, &state.info, nullptr, &pipeline));
  finish(device, made, pipeline, VK_PIPELINE_BIND_POINT_GRAPHICS, desc.name);
  return made;
}

}  // namespace latelight::vk
